"""Small tables with named columns, in any dialect and unit."""

from __future__ import annotations

import math
import re
import time

import numpy as np
import pytest
from machine_exports import workbook

from hyperfab.errors import InputError, UsageError
from hyperfab.io.csv_table import Table, read_table
from hyperfab.io.layout import PLAIN, layout
from hyperfab.io.rows import MAX_ROWS

FILM = {"temperature": "temperature", "h": "film-coefficient"}


def test_columns_are_found_by_name_and_converted() -> None:
    table = read_table(
        b"# source: handbook\nH [W/cm^2/K];Temperature [K]\n0,0005;298,15\n0,0007;323,15\n", "film.csv", FILM
    )
    assert table["temperature"] == pytest.approx([25.0, 50.0], abs=1e-13)
    assert table["h"].tolist() == [5.0, 7.0]
    assert table.lines.tolist() == [3, 4]
    assert table.metadata == {"source": "handbook"}


def test_columns_may_be_asked_for_by_their_unit() -> None:
    table = read_table(b"strain [%],stress [kPa]\n0,0\n50,12.5\n", "foam.csv", {"strain": "-", "stress": "MPa"})
    assert table["strain"].tolist() == [0.0, 0.5]
    assert table["stress"].tolist() == [0.0, 0.0125]


def test_names_as_this_program_writes_them_are_read() -> None:
    table = read_table(b"time_s,centre_degC\n0,25\n60,31.5\n", "heat.csv", {"time": "time"}, rest="temperature")
    assert table["time"].tolist() == [0.0, 60.0]
    assert table["centre"].tolist() == [25.0, 31.5]
    table = read_table(b"depth_mm,force_N\n0,0\n1,2\n", "contact.csv", {"depth": "length", "force": "force"})
    assert table["force"].tolist() == [0.0, 2.0]
    markers = dict.fromkeys(("x0", "y0", "x", "y", "z"), "length")
    table = read_table(b"x0 [mm],y0 [mm],x [mm],y [mm],z [cm]\n0,0,1,2,.3\n", "markers.csv", markers)
    assert table["z"].tolist() == [3.0]


def test_thermocouples_are_one_column_a_probe() -> None:
    table = read_table(
        b"time [min],T1 [degC],T2 (K),heater [%]\n0,20,293.15,0\n1,21,294.15,50\n",
        "t.csv",
        {"time": "time"},
        rest="temperature",
        increasing="time",
    )
    assert list(table.columns) == ["time", "T1", "T2"]
    assert table["time"].tolist() == [0.0, 60.0]
    assert table["T2"] == pytest.approx([20.0, 21.0], abs=1e-12)


def test_optional_columns_are_read_where_they_are() -> None:
    both = {"optional": {"contact": "dimensionless", "thickness": "length"}}
    table = read_table(b"x [mm],contact\n1,0\n2,1\n", "press.csv", {"x": "length"}, **both)
    assert "contact" in table
    assert "thickness" not in table


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "temperature [degC],k [W/m/K]\n1,2\n2,3\n",
            r'line 1: has no column h; its columns are .*"h \[W/m\^2/K\]"',
        ),
        ("temperature [degC],h [W/m^2/K]\n100,2\n50,3\n", r"line 3, column .*50 does not follow 100"),
        ("temperature [degC],h [W/m^2/K]\n50,2\n50,3\n", r"line 3, column .*50 does not follow 50"),
        ("temperature,h [W/m^2/K]\n50,2\n60,3\n", r"line 1.*has no unit"),
        ("temperature [degC],h [W/m/K]\n50,2\n60,3\n", r"line 1.*W/m/K is no unit of film coefficient"),
        ("temperature [degC],h [W/m^2/K]\n50,2\n60,\n", r"line 3.*empty"),
        ("temperature [degC],h [W/m^2/K]\n", r"no rows"),
    ],
)
def test_tables_that_cannot_be_used_are_refused_with_their_place(text: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read_table(text.encode(), "film.csv", FILM, increasing="temperature")


def test_no_probe_is_told() -> None:
    with pytest.raises(InputError, match="one a probe"):
        read_table(b"time [s],heater [%]\n0,0\n1,50\n", "t.csv", {"time": "time"}, rest="temperature")


@pytest.mark.parametrize(
    "data",
    [
        b"\n" * (MAX_ROWS + 5000),
        b"a,b\n" + b"1,2\n" * (MAX_ROWS + 5000),
        b"," * 30_000_000,
        b"a\n" + b"1" * 30_000_000,
        b'a,b\n"' + b"," * 30_000_000,
        b"time [s],h [W/m^2/K]\n" + b"9" * 4000 + b",1\n",
        b"#" * 30_000_000,
        b"(" * 30_000_000,
        b"[" * 100_000 + b",b\n1,2\n",
        b"a,b\n" + b'"' * 5_000_001,
        b"1;" * 5_000_000 + b"\n" + b"1;" * 5_000_000,
        b"\xff\xfe" + b"\x00\xd8" * 1_000_000,
        bytes(30_000_000),
    ],
    ids=lambda data: repr(data[:12]),
)
def test_hostile_tables_are_refused_in_time(data: bytes) -> None:
    start = time.process_time()
    with pytest.raises(InputError):
        read_table(data, "a.csv", FILM)
    assert time.process_time() - start < 2.0


def test_a_large_recording_is_read_in_time() -> None:
    rows = "".join(f"{i / 100:.2f};{20 + i / 1e4:.4f}\n" for i in range(300_000)).replace(".", ",")
    start = time.process_time()
    table = read_table(b"time [s];T1 [degC]\n" + rows.encode(), "t.csv", {"time": "time"}, rest="temperature")
    assert time.process_time() - start < 3.0
    assert len(table["time"]) == 300_000


def test_thermocouples_without_a_unit_are_asked_for_in_one_line_that_settles_it() -> None:
    def read(*columns: str) -> Table:
        data = b"Time,Q1,T1,T2\n0,50,25,24\n60,50,31.5,24.5\n"
        return read_table(
            data, "t.csv", {"time": "time"}, rest="temperature", called=["T1", "T2"], layout=layout(columns)
        )

    option = "Time=time [s],T1=temperature [degC],T2=temperature [degC]"
    with pytest.raises(InputError, match=re.escape(f'say --columns "{option}"')):
        read()
    table = read(option)
    assert (table["time"].tolist(), table["T1"].tolist(), table["T2"].tolist()) == (
        [0, 60],
        [25, 31.5],
        [24, 24.5],
    )


def test_a_head_behind_a_comment_mark_may_tell_the_time_of_day_and_a_probe_may_have_a_dash() -> None:
    """A logger's table for another program: its head a comment, the date and the time of day behind the titles."""
    data = b"%Time (sec)\tTC 1\tTC 2 - near_heater\t\t10/10/2019\t1:46 PM\n0\t25\t24\t\t\t\n60\t31.5\t24.5\t\t\t\n"

    def read(*columns: str) -> Table:
        called = ["TC 1", "TC 2 - near_heater"]
        return read_table(data, "t.txt", {"time": "time"}, rest="temperature", called=called, layout=layout(columns))

    option = "TC 1=temperature [degC],TC 2 - near_heater=temperature [degC]"
    with pytest.raises(InputError, match=re.escape(f'say --columns "{option}"')):
        read()
    table = read(option)
    assert table["time"].tolist() == [0, 60]
    assert table["TC 2 - near_heater"].tolist() == [24, 24.5]


def test_a_column_that_is_set_aside_is_no_probe() -> None:
    data = b"time [s],T1 [degC],room [degC]\n0,25,20\n60,31.5,20\n"
    table = read_table(data, "t.csv", {"time": "time"}, rest="temperature", layout=layout(["room [degC]=aside"]))
    assert list(table.columns) == ["time", "T1"]


def test_a_column_that_nothing_names_is_proposed_where_the_command_has_the_option() -> None:
    data = b"Abscissa,Comment,T1 [degC]\n0,,25\n60,,31.5\n"
    with pytest.raises(InputError, match=re.escape('--columns "Abscissa=time [s]"')):
        read_table(data, "t.lvm", {"time": "time"}, rest="temperature", layout=layout())
    with pytest.raises(InputError, match="has no column time") as caught:
        read_table(data, "schedule.csv", {"time": "time"}, rest="temperature")
    assert "--columns" not in str(caught.value)


def test_a_column_without_a_title_is_proposed_by_its_number() -> None:
    data = b",T1 [degC]\n0,25\n60,31.5\n"
    with pytest.raises(InputError, match=re.escape('--columns "#1=time [s]"')):
        read_table(data, "t.csv", {"time": "time"}, rest="temperature", layout=layout())
    table = read_table(data, "t.csv", {"time": "time"}, rest="temperature", layout=layout(["#1=time [s]"]))
    assert table["time"].tolist() == [0.0, 60.0]


def test_a_probe_without_a_unit_beside_others_that_have_one_is_asked_for() -> None:
    def read(*columns: str) -> Table:
        data = b"Elapsed (min);T1 (\xc2\xb0C);T2;Room\n0;25,1;24,1;20\n1;31,5;24,5;20\n"
        return read_table(
            data, "t.csv", {"time": "time"}, rest="temperature", called=["T1", "T2"], layout=layout(columns)
        )

    with pytest.raises(InputError, match="T2 has no unit of a temperature, which others have") as caught:
        read()
    assert '--columns "T2=temperature [degC]"' in str(caught.value)
    table = read("T2=temperature [degC]")
    assert (table["time"].tolist(), table["T2"].tolist()) == ([0.0, 60.0], [24.1, 24.5])
    assert [one.title for one in table.aside] == ["Room"]
    assert [one.title for one in read("T2=aside").aside] == ["Room"]


def test_an_empty_column_is_no_probe_that_lacks_its_unit() -> None:
    data = b"time [s],T1 [degC],T2,T3\n0,20,,21\n60,20,,22\n"
    with pytest.raises(InputError, match="T3 has no unit") as caught:
        read_table(data, "t.csv", {"time": "time"}, rest="temperature", called=["T1", "T2", "T3"], layout=layout())
    assert '--columns "T3=temperature [degC]"' in str(caught.value)


def test_constants_beside_the_first_row_alone_do_not_make_the_others_short() -> None:
    data = b"time [s],T1 [degC],Material_rho,Length\n0,25,7850,0.01\n60,31.5\n120,33\n"
    table = read_table(data, "t.csv", {"time": "time"}, rest="temperature")
    assert table["T1"].tolist() == [25, 31.5, 33]


@pytest.mark.parametrize(
    ("head", "moments"),
    [
        ("Datum;Uhrzeit", ("14.03.2025;23:59:30", "15.03.2025;00:00:00", "15.03.2025;00:01:00")),
        ("Zeitstempel", ("14.03.2025 23:59:30", "15.03.2025 00:00:00", "15.03.2025 00:01:00")),
        ("Horodatage", ("2025-03-14T23:59:30Z", "2025-03-15T00:00:00Z", "2025-03-15T00:01:00Z")),
        ("Scan;Time of day", ("1;11:59:30 PM", "2;12:00:00 AM", "3;12:01:00 AM")),
    ],
)
def test_a_loggers_clock_is_the_time_whatever_it_is_called(head, moments) -> None:
    rows = "".join(f"{moment};{25 + i},5\n" for i, moment in enumerate(moments))
    table = read_table(f"{head};cup [\u00b0C]\n{rows}".encode(), "log.csv", {"time": "time"}, rest="temperature")
    assert table["time"].tolist() == [0.0, 30.0, 90.0]
    assert table["cup"].tolist() == [25.5, 26.5, 27.5]


@pytest.mark.parametrize(
    ("head", "moments"),
    [
        ("Time (mm:ss)", ("00:00", "00:30", "01:30")),  # not hours and minutes, sixty times as long
        ("Time [min]", ("00:00", "00:30", "01:30")),
        ("Time (hh:mm)", ("00:00", "00:01", "00:02")),
        ("Time", ("00:00.0", "00:30.0", "01:30.0")),  # as spreadsheets export an hour and less
        ("Elapsed", ("59:00", "59:30", "1:00:30")),
        ("Time", ("9:58", "9:59", "10:00")),
        ("time", ("9h58m41s", "9h59m11s", "10h00m11s")),
        ("time", ("0m0s", "0 m 30 s", "1 m 30.0 s")),
        ("Time", ("05/04/2023 09:58:41:120", "05/04/2023 09:59:11:120", "05/04/2023 10:00:11:120")),
        ("", ("2023-05-04T09:58:41+02:00", "2023-05-04T09:59:11+02:00", "2023-05-04T09:00:11+01:00")),
        ("Fecha y hora", ("04/05/2023 11:59:30 a. m.", "04/05/2023 12:00:00 p. m.", "04/05/2023 12:01:00 p. m.")),
    ],
)
def test_clocks_of_two_parts_in_letters_and_with_zones(head, moments) -> None:
    rows = "".join(f"{moment};{25 + i},5\n" for i, moment in enumerate(moments))
    table = read_table(f"{head};cup [\u00b0C]\n{rows}".encode(), "log.csv", {"time": "time"}, rest="temperature")
    apart = [0.0, 60.0, 120.0] if moments[0] in ("9:58",) or "hh" in head else [0.0, 30.0, 90.0]
    assert table["time"].tolist() == pytest.approx(apart, abs=1e-6)


@pytest.mark.parametrize("above", ["", "Anlage 3\n"])
@pytest.mark.parametrize("missing", ["26.0", "---"])
def test_a_long_log_whose_clock_is_called_anything_is_read_to_its_end(above, missing) -> None:
    cups = ["25.0"] * 450 + [missing] + ["27.0"] * 449
    rows = [f"14.03.2024 {8 + k // 60:02d}:{k % 60:02d}:00;{cup};4.0\n" for k, cup in enumerate(cups)]
    log = f"{above}Uhrzeit;cup;Leistung\n;\u00b0C;kW\n" + "".join(rows)
    asked = {"optional": {"power": "power"}, "rest": "temperature", "gaps": True}
    table = read_table(log.encode(), "log.csv", {"time": "time"}, **asked)
    assert table["time"].tolist() == [60.0 * k for k in range(900)]
    assert sum(map(math.isfinite, table["cup"])) == 899 + (missing == "26.0")


@pytest.mark.parametrize(
    ("clock", "moments"),
    [
        ("hh:mm:ss", ("08:10:00", "08:10:30", "08:11:30")),
        ("TT.MM.JJJJ hh:mm:ss", ("14.03.2024 08:10:00", "14.03.2024 08:10:30", "14.03.2024 08:11:30")),
        ("[mm:ss]", ("00:00", "00:30", "01:30")),
        ("HH:MM", ("00:00", "00:01", "00:02")),
    ],
)
def test_how_a_clock_is_written_stands_in_the_row_of_units(clock, moments) -> None:
    rows = "".join(f"{moment};{25 + i},5;4,0\n" for i, moment in enumerate(moments))
    log = f"Protokoll Presse 3\nUhrzeit;cup;Leistung\n{clock};\u00b0C;kW\n{rows}".encode()
    table = read_table(log, "log.csv", {"time": "time"}, optional={"power": "power"}, rest="temperature")
    assert table["time"].tolist() == ([0.0, 60.0, 120.0] if clock == "HH:MM" else [0.0, 30.0, 90.0])
    assert (table["cup"].tolist(), table["power"].tolist()) == ([25.5, 26.5, 27.5], [4000.0] * 3)


def test_a_power_in_per_cent_of_a_rating_is_left_aside() -> None:
    log = b"Zeit [s];cup [degC];Leistung [%]\n0;20;100\n1;21;100\n2;22;0\n"
    table = read_table(log, "log.csv", {"time": "time"}, optional={"power": "power"}, rest="temperature")
    assert ([*table.columns], [one.title for one in table.aside]) == (["time", "cup"], ["Leistung [%]"])


def test_what_counts_up_in_two_parts_is_hours_or_minutes_by_its_unit() -> None:
    log = b"Time;cup [degC]\n00:00;20\n00:30;21\n01:30;22\n"
    with pytest.raises(InputError, match="01:30: hours and minutes, or minutes and seconds") as caught:
        read_table(log, "log.csv", {"time": "time"}, rest="temperature", layout=PLAIN)
    assert '"Time=time [min]" for minutes' in str(caught.value)
    for unit, apart in (("min", [0.0, 30.0, 90.0]), ("h", [0.0, 1800.0, 5400.0])):
        told = layout([f"Time=time [{unit}]"])
        assert read_table(log, "log.csv", {"time": "time"}, rest="temperature", layout=told)["time"].tolist() == apart


def test_a_date_alone_is_no_time() -> None:
    with pytest.raises(InputError, match="has no column time"):
        read_table(b"Datum;T [degC]\n14.03.2025;20\n15.03.2025;21\n", "log.csv", {"time": "time"}, rest="temperature")


@pytest.mark.parametrize("columns", [["Kraft=force [N],Kraft=extension [mm]"], ["Kraft=force [N]", "Kraft=force [kN]"]])
def test_a_column_that_is_said_to_be_two_things_is_refused(columns: list[str]) -> None:
    with pytest.raises(UsageError, match="Kraft is said to be two things"):
        layout(columns)
    assert len(layout(["Kraft=force [N],Weg=extension [mm]", "Kraft=force [N]"]).columns) == 2


@pytest.mark.parametrize(
    ("title", "step"), [("Minutes", 60.0), ("Seconds", 1.0), ("Stunden", 3600.0), ("X_Value", 1.0)]
)
def test_a_title_that_is_a_unit_of_time_is_the_time(title: str, step: float) -> None:
    table = read_table(f"{title}\tcup [C]\n0\t20\n2\t21\n".encode(), "log.lvm", {"time": "time"}, rest="temperature")
    assert table["time"].tolist() == [0.0, 2.0 * step]


def test_a_message_proposes_no_column_that_is_known_to_be_something_else() -> None:
    with pytest.raises(InputError, match="has no column x0") as caught:
        read_table(b"Point,X,Y,Z\n1,2,3,4\n", "a.csv", dict.fromkeys(("x0", "x", "y", "z"), "length"), layout=PLAIN)
    assert "Point=" not in str(caught.value)


def test_columns_without_units_are_told_at_once() -> None:
    with pytest.raises(InputError, match="X0, Y0 have no unit") as caught:
        read_table(b"X0,Y0\n1,2\n", "a.csv", {"x0": "length", "y0": "length"}, layout=PLAIN)
    assert '"X0=x0 [mm],Y0=y0 [mm]"' in str(caught.value)


def test_a_probe_with_a_letter_for_its_unit_is_asked_for_in_degrees() -> None:
    with pytest.raises(InputError) as caught:
        read_table(
            b"time_s,centre_c,edge_c\n0,20,21\n",
            "a.csv",
            {"time": "time"},
            rest="temperature",
            called=["centre", "edge"],
            layout=PLAIN,
        )
    assert '"centre_c=centre [degC],edge_c=edge [degC]"' in str(caught.value)


def test_a_labview_measurement_begins_behind_its_last_header() -> None:
    head = "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\nChannels\t2\t\t\nSamples\t2\t2\t\n"
    head += "Y_Unit_Label\tDeg C\tDeg C\t\nX_Dimension\tTime\tTime\t\nX0\t0.0E+0\t0.0E+0\t\n***End_of_Header***\t\t\t\n"
    text = head + "X_Value\tcup [C]\tedge [C]\tComment\n0.0\t20.5\t21\t\n10.0\t22.5\t23\t\n"
    table = read_table(text.encode(), "log.lvm", {"time": "time"}, rest="temperature")
    assert (table["time"].tolist(), table["edge"].tolist()) == ([0.0, 10.0], [21.0, 23.0])


def test_units_of_channels_stand_above_a_head_beside_what_else_is_told_of_them() -> None:
    """LabVIEW and recorders write them there; degrees Fahrenheit were asked for as [degC], to be pasted."""
    head = "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\nChannels\t2\t\t\nSamples\t2\t2\t\n"
    head += "Y_Unit_Label\tDeg F\tDeg F\t\nX_Dimension\tTime\tTime\t\nX0\t0.0E+0\t0.0E+0\t\n***End_of_Header***\t\t\n"
    text = head + "X_Value\tcup\tedge\tComment\n0.0\t212\t32\t\n10.0\t212\t50\t\n"
    table = read_table(text.encode(), "log.lvm", {"time": "time"}, rest="temperature", called=["cup", "edge"])
    assert table["edge"] == pytest.approx([0.0, 10.0])
    text = "Model,GX10\nUnit,,degF,degF\nRange,,1,2\nSensor,,K,K\nDate,Time,cup,edge\n"
    text += "2024/03/01,10:00:00,212,32\n2024/03/01,10:00:10,212,50\n"
    table = read_table(text.encode(), "gx.csv", {"time": "time"}, rest="temperature", called=["cup", "edge"])
    assert (table["time"].tolist(), table["edge"].round(6).tolist()) == ([0.0, 10.0], [0.0, 10.0])


@pytest.mark.parametrize("word", ["+OVER", "-OVER", "Over", "UNDER", "BURNOUT", "Burn-out", "9.9E+37", "-9.90000E+37"])
def test_an_instrument_that_is_beyond_its_range_leaves_a_gap(word: str) -> None:
    text = f"Time [s],cup [\u00b0C],edge [\u00b0C]\n0,20.5,21\n10,{word},22\n20,23.5,23\n"
    table = read_table(text.encode(), "log.csv", {"time": "time"}, rest="temperature", gaps=True)
    assert [math.isnan(one) for one in table["cup"]] == [False, True, False]


@pytest.mark.parametrize("title", ["101 <cup> (C)", "cup Ave. (\u00b0C)", "Cup_Last [degC]", "T1 (cup) [degC]"])
def test_a_logger_tells_a_probe_beside_its_channel_or_how_it_was_averaged(title: str) -> None:
    text = f"Time [s],{title},edge [degC],edge Ave. 2 [degC]\n0,20.5,21,20\n10,22,22,20\n"
    table = read_table(text.encode(), "log.csv", {"time": "time"}, rest="temperature", called=["cup", "edge"])
    assert list(table.columns)[2:] == ["edge", "edge Ave. 2"]
    assert [one.casefold() for one in list(table.columns)[1:2]] == ["cup"]
    assert table[list(table.columns)[1]].tolist() == [20.5, 22.0]


@pytest.mark.parametrize(
    "dates",
    [
        ("03/01/2024", "03/02/2024"), ("01/03/2024", "02/03/2024"), ("03/12/24", "03/13/24"), ("31.1.2024", "1.2.2024"),
        ("2024-03-01", "2024-03-02"), ("12/31/2023", "01/01/2024"), ("02/29/2024", "03/01/2024"),
    ],
)  # fmt: skip
def test_a_log_past_midnight_goes_on_by_a_day_whichever_way_dates_are_written(dates: tuple[str, str]) -> None:
    """Of 03/01 and 03/02 the second was a month later, in silence."""
    rows = f"{dates[0]} 23:59:50,20\n{dates[1]} 00:00:00,21\n{dates[1]} 00:00:10,22\n"
    table = read_table(f"Time,cup [degC]\n{rows}".encode(), "log.csv", {"time": "time"}, rest="temperature")
    assert table["time"].tolist() == [0.0, 10.0, 20.0]


def test_degrees_stand_before_the_name_of_a_probe_and_an_open_sensor_is_a_gap() -> None:
    text = "Time [s];\u00b0C [1] cup;[\u00b0C] edge\n0;20,5;21\n10;OL;22\n20;23,5;-----\n"
    table = read_table(text.encode(), "log.csv", {"time": "time"}, rest="temperature", gaps=True)
    assert [table[probe].tolist()[0] for probe in ("cup", "edge")] == [20.5, 21.0]
    assert [math.isnan(table["cup"][1]), math.isnan(table["edge"][1])] == [True, False]


def test_a_cloud_of_points_is_told_as_that() -> None:
    with pytest.raises(InputError, match="is a cloud of points"):
        read_table(b"ply\nformat ascii 1.0\nend_header\n1 2 3\n", "a.ply", {"x": "length"})


#: Tables that cannot be read as they are, and what is to be done to the file.
_AS_THEY_ARE = {
    "no head": (b"20,8\n100,9\n", 'name the columns, as in "temperature [degC],h [W/m^2/K]"'),
    "no units": (b"temperature,h\n20,8\n100,9\n", 'write it behind the name, as in "temperature [degC]"'),
    "another unit": (b"temperature [degC],h [W/m/K]\n20,8\n100,9\n", "correct the heads of its columns"),
    "two of a kind": (b"temperature [degC],h [W/m^2/K],h [W/m^2/K]\n20,8,9\n", "correct the heads of its columns"),
    "decimals": (b"temperature [degC];h [W/m^2/K]\n20;1,250\n90;2,250\n", "one number with four decimals, as 1.2500"),
}


@pytest.mark.parametrize(("data", "said"), _AS_THEY_ARE.values(), ids=_AS_THEY_ARE)
def test_a_table_that_a_document_names_is_told_no_option(data: bytes, said: str) -> None:
    """``hf mold-heat`` has no --columns and no --decimal: who pasted them was told that there is no such option."""
    with pytest.raises(InputError) as found:
        read_table(data, "film.csv", FILM)
    assert str(found.value).endswith(said)
    assert "--" not in str(found.value)
    with pytest.raises(InputError, match=r"--(columns|decimal) "):
        read_table(data, "film.csv", FILM, layout=PLAIN)
    head = data.replace(b"1,250", b"1,2500")
    if head != data:  # and what it says helps
        assert read_table(head, "film.csv", FILM)["h"].tolist() == [1.25, 2.25]


@pytest.mark.parametrize(
    ("days", "clock"),
    [(("01.03.2024", "02.03.2024", "03.03.2024"), ("09:00:00", "10:00:00", "09:00:00")),
     (("3/1/2024", "3/2/2024", "3/3/2024"), ("9:00 AM", "10:00 AM", "9:00 AM"))],
)  # fmt: skip
def test_a_column_of_dates_tells_the_days_of_the_clock_beside_it(days: tuple[str, ...], clock: tuple[str, ...]) -> None:
    """A day between two rows was an hour, without a word but that the dates were not used."""
    rows = "".join(f"{day},{time},{t}\n" for day, time, t in zip(days, clock, (22, 80, 30), strict=True))
    table = read_table(f"Date,Time,T1 [degC]\n{rows}".encode(), "t.csv", {"time": "time"}, rest="temperature")
    assert table["time"].tolist() == [0.0, 90000.0, 172800.0]
    assert table.aside == ()
    # One day throughout is that of the start: past midnight the clock tells the next by itself.
    text = "Date;Time;T1 [degC]\n1.3.2024;23:59:00;20\n1.3.2024;00:01:00;21\n"
    assert read_table(text.encode(), "t.csv", {"time": "time"}, rest="temperature")["time"].tolist() == [0.0, 120.0]


@pytest.mark.parametrize("head", ["Time [d]", "unix_time", "unix time"])
def test_a_time_that_counts_from_an_epoch_begins_with_its_first_row(head: str) -> None:
    first, step = (45356.5, 1.0 / 1440.0) if "d" in head else (1709678472.0, 60.0)
    text = f"{head},T1 [degC]\n" + "".join(f"{first + k * step:.7f},{20 + k}\n" for k in range(3))
    table = read_table(text.encode(), "t.csv", {"time": "time"}, rest="temperature")
    assert table["time"] == pytest.approx([0.0, 60.0, 120.0], abs=0.01)


def test_a_date_of_a_spreadsheet_is_asked_for_in_days() -> None:
    text = b"Time,T1 [degC]\n45356.5,20\n45356.6,21\n"
    with pytest.raises(InputError, match=r'"Time=time \[d\]"'):
        read_table(text, "t.csv", {"time": "time"}, rest="temperature", layout=PLAIN)


@pytest.mark.parametrize(
    "titles",
    [
        ("101 cup (C)", "102 base (C)"),
        ("PT100_cup_degC", "PT100_base_degC"),
        ("cup.Avg [degC]", "base.Mean [degC]"),
        ('"Temp, °C (LGR S/N: 1, SEN S/N: 2, LBL: cup)"', '"Temp, °C (LGR S/N: 1, SEN S/N: 3, LBL: base)"'),
        ("cup °C", "TC 4: base °C"),
    ],
)
def test_a_probe_is_known_behind_what_reads_it_and_by_its_label(titles: tuple[str, str]) -> None:
    """HOBO's two columns were both called Temp and refused; the others had to be named by hand."""
    text = f"Time [s],{','.join(titles)}\n0,20,21\n60,30,31\n"
    table = read_table(text.encode(), "t.csv", {"time": "time"}, rest="temperature", called=("cup", "base"))
    assert [*table.columns] == ["time", "cup", "base"]
    # A set point is no probe.
    text = "Time [s],cup set (C)\n0,20\n60,30\n"
    assert "cup" not in read_table(text.encode(), "t.csv", {"time": "time"}, rest="temperature", called=("cup",))


def test_a_recorder_sets_signs_apart_and_says_again_what_has_no_unit() -> None:
    rows = "".join(f"{k},2024/03/05 23:41:{12 + k},000,+     {21 + k}.8,-      3.5,LLLL\n" for k in range(3))
    text = f"Model,GL\n\nData\nNumber,Date&Time,ms,CH1,CH2,Alarm1-10\nNO.,Time,ms,degC,degC,A1234567890\n{rows}"
    table = read_table(text.encode(), "t.csv", {"time": "time"}, rest="temperature", layout=PLAIN)
    assert table["time"].tolist() == [0.0, 1.0, 2.0]
    assert table["CH1"].tolist() == [21.8, 22.8, 23.8]
    assert table["CH2"].tolist() == [-3.5, -3.5, -3.5]


def test_what_several_heaters_draw_adds_up_where_it_is_called_power() -> None:
    text = b"time [s],T [degC],P1 (W),P2 (kW)\n0,20,100,0.2\n60,30,50,0\n"
    told = layout(["P1 (W)=power [W],P2 (kW)=power [kW]"], own=("power",))
    table = read_table(text, "t.csv", {"time": "time"}, optional={"power": "power"}, rest="temperature", layout=told)
    assert table["power"].tolist() == [300.0, 50.0]
    assert table.aside == ()


def test_the_option_that_is_shown_for_a_column_has_its_own_unit() -> None:
    """Of a depth in inches the option said mm: pasted, it made 25 mm of 1."""
    with pytest.raises(InputError, match=r'--columns "Extension \(in\)=depth \[in\]"'):
        read_table(
            b"Specimen,Extension (in),Load (lbf)\n1,0,0\n1,0.5,2\n", "b.csv", {"depth": "length", "force": "force"},
            layout=PLAIN,
        )  # fmt: skip


def test_a_log_with_a_row_for_each_reading_has_a_column_for_each_probe() -> None:
    """It was refused as going back in time, to be sorted."""
    rows = "".join(
        f"2024-03-05T23:41:{k:02d},{one},{20 + k + d}\n" for k in range(3) for d, one in enumerate(("cup", "Base"))
    )
    text = f"timestamp,sensor,value_C\n{rows}2024-03-05T23:41:09,cup,29\n"
    read = {"rest": "temperature", "called": ("cup", "base", "rim"), "gaps": True}
    table = read_table(text.encode(), "t.csv", {"time": "time"}, **read)  # type: ignore[arg-type]
    assert [*table.columns] == ["time", "cup", "base"]
    assert table["time"].tolist() == [0.0, 1.0, 2.0, 9.0]
    assert table["cup"].tolist() == [20.0, 21.0, 22.0, 29.0]
    assert table["base"][:3].tolist() == [21.0, 22.0, 23.0]
    assert math.isnan(table["base"][3])
    with pytest.raises(InputError, match="lid is no probe of the mold; it has cup, base, rim"):
        read_table(text.replace("Base", "lid").encode(), "t.csv", {"time": "time"}, increasing="time", **read)  # type: ignore[arg-type]


LONG = {"rest": "temperature", "called": ("cup", "base"), "gaps": True, "increasing": "time"}


@pytest.mark.parametrize(
    ("head", "row", "names", "columns"),
    [
        ("VarName;TimeString;VarValue;Validity;Time_ms", "{name};05.03.2024 23:41:{second};{value};1;45356987{k},5",
         ("PT100_cup", "PT100_base"), "VarValue=temperature [degC]"),
        ("Zeit;Messstelle;Wert", "{second};{name};{value}", ("cup", "base"),
         "Wert=temperature [degC],Zeit=time [s]"),
        ("Timestamp,Serial,Temp_C", "2024-03-05T23:41:{second},{name},{value}", ("28-01ff", "28-02ab"),
         "28-01ff=cup,28-02ab=base"),
    ],
    ids=["WinCC", "no unit", "serials"],
)  # fmt: skip
def test_what_a_long_log_leaves_open_is_settled_by_the_option_that_is_shown(head, row, names, columns) -> None:
    """Days times a million were milliseconds, serials went back in time, to be sorted, and no option was shown."""
    log = head + "\n" + "".join(
        row.format(name=name, second=f"{10 + 20 * k}", value=20 + 5 * k + d, k=100 + 231 * k) + "\n"
        for k in range(3) for d, name in enumerate(names)
    )  # fmt: skip
    with pytest.raises(InputError) as caught:
        read_table(log.encode(), "log.csv", {"time": "time"}, layout=PLAIN, **LONG)  # type: ignore[arg-type]
    assert f'--columns "{columns}"' in str(caught.value)
    how = layout([columns], own=("cup", "base"))
    table = read_table(log.encode(), "log.csv", {"time": "time"}, layout=how, **LONG)  # type: ignore[arg-type]
    assert np.diff(table["time"]).tolist() == [20.0, 20.0]
    assert (table["cup"].tolist(), table["base"].tolist()) == ([20.0, 25.0, 30.0], [21.0, 26.0, 31.0])


def test_what_is_no_probe_in_a_long_log_may_be_set_aside() -> None:
    """WinCC ends its export with a row of its own; the heaters' power stands between the temperatures."""
    log = "".join(
        f"2024-03-05T23:41:{k:02d},{one},{20 + k + d}\n" for k in range(3) for d, one in enumerate(("cup", "base"))
    )
    log = f"Time,Tag,Temp [degC]\n{log}2024-03-05T23:42:00,$RT_OFF$,0\n"
    with pytest.raises(InputError, match=r"\$RT_OFF\$ is no probe of the mold; .*'\$RT_OFF\$=aside'"):
        read_table(log.encode(), "log.csv", {"time": "time"}, layout=PLAIN, **LONG)  # type: ignore[arg-type]
    how = layout(["$RT_OFF$=aside"], own=("cup", "base"))
    table = read_table(log.encode(), "log.csv", {"time": "time"}, layout=how, **LONG)  # type: ignore[arg-type]
    assert table["time"].tolist() == [0.0, 1.0, 2.0]


@pytest.mark.parametrize(
    ("log", "said"),
    [
        ("Time;Data.T_cup;Data.T_base\n0;1,5;2,5\n1;1,5;2,5\n",
         '"Time=time [s],Data.T_cup=cup [degC],Data.T_base=base [degC]"'),
        ("Time [s],Chan001 cup,Chan002 base\n0,1,2\n1,2,3\n", '"Chan001 cup=cup [degC],Chan002 base=base [degC]"'),
        ("Milliseconds,cup [degC]\n0,20\n1000,21\n", '"Milliseconds=time [ms]"'),
        ("time [s],flow,cup [degC]\n0,1,20\n0,2,21\n", "sort the rows, each value once"),
        ("Run,time [s],cup [degC]\n1,0,20\n1,1,21\n2,0,20\n", "keep the rows of one Run"),
        ("Run,time [s],cup [degC]\n1,0,20\n1,1,21\n2,0,20\n2,1,21\n", "keep the rows of one Run"),
    ],
)  # fmt: skip
def test_what_a_log_lacks_is_shown_with_its_own_columns(log: str, said: str) -> None:
    """To name columns T1 was asked for, and to sort a log of two runs."""
    with pytest.raises(InputError) as caught:
        read_table(log.encode(), "log.csv", {"time": "time"}, layout=PLAIN, **LONG)  # type: ignore[arg-type]
    assert said in str(caught.value)


def test_a_picture_is_no_log() -> None:
    """The first columns of a thermogram were offered as the time and the probes."""
    picture = "".join(";".join(f"{20 + (k * j) % 7},5" for j in range(9)) + "\n" for k in range(1, 6))
    with pytest.raises(InputError, match="is a grid of readings, cell beside cell; write a row for each reading"):
        read_table(f"Emissivity;0,95\n\n{picture}".encode(), "t.csv", {"time": "time"}, layout=PLAIN, **LONG)  # type: ignore[arg-type]


def test_markers_may_be_called_flat_and_draped() -> None:
    columns = dict.fromkeys(("x0", "y0", "x", "y", "z"), "length")
    table = read_table(b"id,flat_x_mm,flat_y_mm,draped_x_mm,draped_y_mm,draped_z_mm\n1,2,3,4,5,6\n", "m.csv", columns)
    assert [float(table[one][0]) for one in columns] == [2.0, 3.0, 4.0, 5.0, 6.0]


def test_a_dot_groups_thousands_in_a_column_of_whole_numbers_too() -> None:
    """Of 1.600 and 1.225,8 in one file the comma is the decimal mark: whole numbers were a thousandth of themselves."""
    text = "Tiefe [µm];Kraft [mN]\n0;0,0\n800;345,6\n1.600;1.225,8\n"
    table = read_table(text.encode(), "a.csv", {"tiefe": "length", "kraft": "force"})
    assert table["tiefe"] == pytest.approx([0.0, 0.8, 1.6])
    assert table["kraft"] == pytest.approx([0.0, 0.3456, 1.2258])


def log(text: str, called: tuple[str, ...] = ("cup", "base")) -> Table:
    return read_table(text.encode(), "log.csv", {"time": "time"}, layout=PLAIN, **{**LONG, "called": called})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "text",
    [
        "No.;Time [s];Chan001 cup;Unit;Chan002 base;Unit\n1;0;71,6;F;22,5;C\n2;20;73,4;F;24,0;C\n",
        "time [s],cup value,unit,base value,unit\n0,71.6,Degree F,22.5,Degree C\n20,73.4,Degree F,24.0,Degree C\n",
        "Zeit;Messstelle;Wert;Einheit\n0 s;cup;22;°C\n0 s;base;22,5;°C\n20 s;cup;23;°C\n20 s;base;24;°C\n",
        "Time,cup,base\n0 s,22 °C,22.5 °C\n20 s,23 °C,24.0 °C\n",
    ],
    ids=["pairs", "value and unit", "a row each", "in the cells"],
)
def test_units_that_stand_beside_each_reading_are_read(text: str) -> None:
    """Degrees Fahrenheit were offered as Celsius; rows of seconds in the first column were closing rows, of an s."""
    table = log(text)
    assert table["time"].tolist() == [0.0, 20.0]
    assert table["cup"] == pytest.approx([22.0, 23.0])
    assert table["base"] == pytest.approx([22.5, 24.0])


def test_a_reading_that_lacks_has_no_unit_and_two_units_are_told_by_line() -> None:
    table = log("Time,cup,base\n0 s,22 °C,OPEN\n20 s,23 °C,24.0 °C\n30 s,24 °C,25.0 °C\n")
    assert table["cup"].tolist() == [22.0, 23.0, 24.0]
    with pytest.raises(InputError, match=r'line 2, column "cup": C is in another unit than F in line 3'):
        log("time [s],cup,unit\n0,22,C\n20,73,F\n")


@pytest.mark.parametrize(
    "head",
    [
        "Time;cup;base\ns;°C;°C\nDT_DOUBLE;DT_DOUBLE;DT_DOUBLE\n",
        "Time;cup;base\nDT_DATE;DT_DOUBLE;DT_DOUBLE\ns;°C;°C\n",
    ],
)
def test_a_row_of_the_types_of_columns_is_no_reading(head: str) -> None:
    assert log(head + "0;22,5;23\n20;24;25\n")["cup"].tolist() == [22.5, 24.0]


def test_channels_that_are_named_above_their_least_and_largest_are_told_apart() -> None:
    text = (
        '"Ch.","","CH1","","CH2",""\n"Tag","","cup","","base",""\n"","","Min","Max","Min","Max"\n'
        '"Unit","","C","C","C","C"\n"2024/03/05","23:41:00","21","23","30","32"\n"2024/03/05","23:41:20","22","24","31","33"\n'
    )
    assert [*log(text).columns] == ["time", "cup Min", "cup Max", "base Min", "base Max"]


@pytest.mark.parametrize(
    "text",
    [
        "Channel,Time [s],T [degC]\ncup,0,20\n,20,21\nbase,0,30\n,20,31\n",
        "Probe: cup\nTime [s],T [degC]\n0,20\n20,21\n\nProbe: base\nTime [s],T [degC]\n0,30\n20,31\n",
        "Channel,cup\nTime [s],T [degC]\n0,20\n20,21\nChannel,base\nTime [s],T [degC]\n0,30\n20,31\n",
    ],
    ids=["merged cells", "named probes", "channels"],
)
def test_probes_one_under_another_are_a_column_each(text: str) -> None:
    table = log(text)
    assert table["time"].tolist() == [0.0, 20.0]
    assert (table["cup"].tolist(), table["base"].tolist()) == ([20.0, 21.0], [30.0, 31.0])


def test_what_is_left_out_of_each_of_the_tables_one_under_another_counts() -> None:
    """That of the first alone did."""
    text = "".join(f"Probe: {one}\nTime [s],T [degC]\n0,20\n20,21\nMean,20.5\n\n" for one in ("cup", "base"))
    assert log(text).left_out == {"closing row, no reading": 2}


def test_probes_one_under_another_may_each_have_a_clock() -> None:
    table = log("Channel,Time [s],T [degC]\ncup,0,20\ncup,20,21\nbase,3,30\nbase,23,31\n")
    assert table["time"].tolist() == [0.0, 3.0, 20.0, 23.0]
    assert table.lines.tolist() == [2, 4, 3, 5]
    assert np.flatnonzero(np.isfinite(table["cup"])).tolist() == [0, 2]
    assert table["base"][[1, 3]].tolist() == [30.0, 31.0]


def test_a_reading_that_lacks_is_not_that_before() -> None:
    table = log("Channel,Time [s],T [degC]\ncup,0,20\ncup,20,\nbase,0,30\nbase,20,31\n")
    assert table["cup"][0] == 20.0
    assert math.isnan(table["cup"][1])


def test_numbers_of_channels_are_asked_for_by_name() -> None:
    """The rows of one channel were to be kept."""
    with pytest.raises(InputError, match=r'column "Channel": numbers what was read .*write the probe in place of each'):
        log("Channel,Time [s],T [degC]\n1,0,20\n1,20,21\n2,0,30\n2,20,31\n")


def test_a_clock_of_minutes_and_seconds_says_so_in_its_head() -> None:
    assert log("Elapsed (min:s),cup [degC]\n0:00,20\n0:20,21\n")["time"].tolist() == [0.0, 20.0]


def test_narrow_blanks_part_thousands() -> None:
    text = "Tiefe [µm];Kraft [mN]\n800;345,6\n1\u2009600;1\u2009225,8\n2\u202f400;2\u2007000,0\n"
    table = read_table(text.encode(), "a.csv", {"tiefe": "length", "kraft": "force"})
    assert table["tiefe"] == pytest.approx([0.8, 1.6, 2.4])
    assert table["kraft"] == pytest.approx([0.3456, 1.2258, 2.0])


@pytest.mark.parametrize("heads", ["Xref,Yref,Xdef,Ydef,Zdef", "x inicial,y inicial,x final,y final,z final"])
def test_markers_may_be_called_first_and_last(heads: str) -> None:
    table = read_table(
        f"{heads}\nmm,mm,mm,mm,mm\n1,2,3,4,5\n".encode(), "a.csv", dict.fromkeys(("x0", "y0", *"xyz"), "length")
    )
    assert [float(table[one][0]) for one in ("x0", "y0", *"xyz")] == [1.0, 2.0, 3.0, 4.0, 5.0]


def test_a_time_of_day_that_a_workbook_keeps_as_a_share_is_offered_as_days() -> None:
    """It was offered as seconds."""
    rows = [[(f"{0.4 + 0.0001 * k:.4f}",), (f"{20 + k}",)] for k in range(3)]
    data = workbook({"Log": [["Time", "cup [degC]"], *rows]})
    with pytest.raises(InputError, match=r'--columns "Time=time \[d\]"'):
        read_table(data, "log.xlsx", {"time": "time"}, layout=PLAIN, **LONG)  # type: ignore[arg-type]
