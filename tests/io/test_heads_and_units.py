"""What stands beside a name in the head of a column is its unit, with its factor, or is asked for."""

from __future__ import annotations

import re

import numpy as np
import pytest

from hyperfab.errors import InputError
from hyperfab.io.csv_tests import TestData, read_tests
from hyperfab.io.layout import layout
from hyperfab.io.unit_table import UnitError, parse_unit

STRIP = "Tensile test\nWidth,50,mm\nThickness,0.8,mm\nGauge length,100,mm\n"
#: 1 N on 50 mm by 0.8 mm [MPa].
N = 1.0 / 40.0


def pulled(load: str, preamble: str = STRIP, columns: str | None = None) -> TestData:
    text = f"{preamble}Extension (mm),{load}\n10,2\n20,4\n"
    told = None if columns is None else layout([columns])
    [found] = read_tests(text.encode(), "a.csv", columns=told)
    return found


@pytest.mark.parametrize(
    ("stated", "head", "on_specimen"),
    [
        ("", "Strain (%)", False),
        ("Strain source,Crosshead\n", "Strain (%)", False),
        ("Strain source,Video extensometer 1\n", "Strain (%)", True),
        ("# extensometer: marker pins\n", "Strain (%)", True),
        ("", "Video strain (%)", True),
    ],
)
def test_a_file_may_say_that_its_strain_is_of_the_specimen(stated: str, head: str, on_specimen: bool) -> None:
    [found] = read_tests(f"# test: tensile\n{stated}{head},Stress (MPa)\n0,0\n10,0.2\n".encode(), "a.csv")
    assert found.on_specimen is on_specimen


def strained(head: str) -> float:
    [found] = read_tests(f'# test: tensile\n"{head}",Stress (MPa)\n0.5,0.1\n2.5,0.2\n'.encode(), "a.csv")
    return float(found.stretch.max())


@pytest.mark.parametrize("key", ["Thickness (h0)", "Thickness (t0)", "Thickness [h0]", "Thickness h0"])
def test_a_symbol_of_the_start_is_no_unit_to_the_power_of_nothing(key: str) -> None:
    sizes = STRIP.replace("Thickness", key).replace("Gauge length", "Gauge length (L0)")
    assert pulled("Load (N)", sizes).stress.tolist() == pytest.approx([2 * N, 4 * N])


@pytest.mark.parametrize("text", ["h0", "t0", "L0", "100 N", "10N", "1000", "x103 N", "x0"])
def test_a_power_of_nothing_and_an_amount_are_no_units(text: str) -> None:
    with pytest.raises(UnitError):
        parse_unit(text)


@pytest.mark.parametrize(
    ("head", "newtons"),
    [
        ("Load (x10 N)", 10.0), ("Load [x100 N]", 100.0), ("Load (N x 10)", 10.0), ("Load (N*1000)", 1000.0),
        ("Load (10^-3 N)", 1e-3), ("Load (×10² N)", 100.0),
        ("Load (Kg)", 9.80665), ("Load (Kgs)", 9.80665), ("Load (gms)", 9.80665e-3), ("Load (kg.f)", 9.80665),
        ("Load (kg-f)", 9.80665), ("Load (lb-f)", 4.4482216152605), ("Load (pounds)", 4.4482216152605),
        ("Load (lbs-force)", 4.4482216152605), ("Load (kips)", 4448.2216152605), ("Load (tf)", 9806.65),
        ("Load (kN) avg", 1000.0),
    ],
)  # fmt: skip
def test_a_factor_and_the_units_of_scales_are_applied(head: str, newtons: float) -> None:
    assert pulled(head).stress.tolist() == pytest.approx([2 * N * newtons, 4 * N * newtons])


@pytest.mark.parametrize(
    ("head", "scale"),
    [("Stress, N/mm2", 1.0), ("Stress, N/cm2", 1e-2), ("Stress, kgf/cm2", 0.0980665), ("Stress in N/mm²", 1.0),
     ("Force, N/mm", 1.25), ("Load, N/5cm", 0.025), ("Tension in N/m", 1.25e-3), ("Load / width, N/mm", 1.25)],
)  # fmt: skip
def test_a_unit_behind_a_comma_may_hold_a_slash(head: str, scale: float) -> None:
    """A force over the width is one of 0.8 mm."""
    text = f'# test: tensile\n# thickness: 0.8 mm\nStrain (%);"{head}"\n10;1\n20;2\n'
    [found] = read_tests(text.encode(), "a.csv")
    assert found.stress.tolist() == pytest.approx([scale, 2.0 * scale])


@pytest.mark.parametrize(
    ("heads", "newtons"),
    [("Перемещение, мм;Нагрузка, Н", 1.0), ("Перемещение (мм);Нагрузка (кН)", 1e3),
     ("Удлинение [мм];Усилие [кгс]", 9.80665)],
)  # fmt: skip
def test_units_stand_in_the_letters_of_their_heads(heads: str, newtons: float) -> None:
    [found] = read_tests(f"{STRIP.replace(',', ';')}{heads}\n10;2\n20;4\n".encode(), "a.csv")
    assert found.stretch.tolist() == pytest.approx([1.1, 1.2])
    assert found.stress.tolist() == pytest.approx([2 * N * newtons, 4 * N * newtons])
    [found] = read_tests("# test: tensile\nДеформация, %;Напряжение, Н/мм2\n10;2\n20;4\n".encode(), "a.csv")
    assert found.stress.tolist() == pytest.approx([2.0, 4.0])


@pytest.mark.parametrize("head", ["Strain, mm/mm", "Strain, m/m", "Strain in mm/mm", "Dehnung, mm/mm"])
def test_a_strain_in_millimetres_over_millimetres_is_no_extension(head: str) -> None:
    [found] = read_tests(f'{STRIP}"{head}","Stress, MPa"\n0.5,0.1\n2.5,0.2\n'.encode(), "a.csv")
    assert found.stretch.tolist() == pytest.approx([1.5, 3.5])


def test_a_force_along_the_axis_of_the_stage_is_the_force() -> None:
    [found] = read_tests(f'{STRIP}"Position (z), mm","Fz, N"\n3,0\n13,2\n23,4\n'.encode(), "a.csv")
    assert found.stretch.tolist() == pytest.approx([1.0, 1.1, 1.2])
    assert found.stress.tolist() == pytest.approx([0.0, 2 * N, 4 * N])


def test_a_speed_behind_a_comma_is_taken() -> None:
    [found] = read_tests(f'{STRIP}"Velocity, mm/s:",0.5\nExtension (mm),Load (N)\n10,2\n20,4\n'.encode(), "a.csv")
    assert found.rate_1_s == pytest.approx(0.005)


def test_a_weight_over_square_centimetres_is_a_stress() -> None:
    [found] = read_tests(b"# test: tensile\nStrain (%),Stress (Kg/sq.cm)\n10,1\n20,2\n", "a.csv")
    assert found.stress.tolist() == pytest.approx([0.0980665, 0.196133])


@pytest.mark.parametrize("unit", ["N/mm²", "N/mm2", "N/mm^2"])
def test_a_unit_with_a_slash_stands_behind_a_title_without_brackets(unit: str) -> None:
    [found] = read_tests(f"# test: tensile\nstrain,stress {unit}\n0.1,2\n0.2,4\n".encode(), "a.csv")
    assert found.stress.tolist() == pytest.approx([2, 4])


@pytest.mark.parametrize("head", ["Load (100 N)", "Load [100 N]", "Load, 100 N", "Load /100N"])
def test_an_amount_in_the_place_of_a_unit_is_asked_for(head: str) -> None:
    """It may be the range of the load cell, or what each number counts for."""
    with pytest.raises(InputError, match="is an amount and no unit") as caught:
        pulled(head if "," not in head else f'"{head}"')
    plain, counted = re.findall(r'--columns "([^"]*)"', str(caught.value))
    told = head if "," not in head else f'"{head}"'
    assert pulled(told, columns=plain).stress.tolist() == pytest.approx([2 * N, 4 * N])
    assert pulled(told, columns=counted).stress.tolist() == pytest.approx([200 * N, 400 * N])


@pytest.mark.parametrize("head", ["Load (quux)", "Load [quux]"])
def test_a_unit_that_nobody_knows_is_told_as_that(head: str) -> None:
    with pytest.raises(InputError, match=r"quux is no unit.*only if the numbers are in N") as caught:
        pulled(head)
    [option] = re.findall(r'--columns "([^"]*)"', str(caught.value))
    assert pulled(head, columns=option).stress[0] == pytest.approx(2 * N)
    assert "has no unit" not in str(caught.value)


@pytest.mark.parametrize(
    "head",
    [
        "Strain (% L0)", "Strain (%GL)", "Strain % of gauge", "Elongation, %", "Elongation%", "Strain(%) avg",
        "Strain_pct", "strain_perc", "Strain_percent", "Strain (percentage)", "Strain (per cent)", "Elongation (pc)",
        "Strain [% of GL]", "Dehnung in Prozent", "Elong. %", "Strain (pct.)", "Dehnung (v. H.)",
        "strain (percent, nominal)",
    ],
)  # fmt: skip
def test_per_cent_anywhere_in_the_head_of_a_strain_is_its_unit(head: str) -> None:
    assert strained(head) == pytest.approx(1.025)


@pytest.mark.parametrize(
    ("head", "factor"),
    [
        ("Strain (10^-3)", 1e-3), ("Strain (1e-3)", 1e-3), ("Strain (x10-2)", 1e-2), ("Strain (1/1000)", 1e-3),
        ("Strain (×10⁻³)", 1e-3),
        ("Strain (microstrain)", 1e-6), ("Strain (µε)", 1e-6),
        ("Strain (nominal)", 1.0), ("Strain (video)", 1.0),
    ],
)  # fmt: skip
def test_a_factor_beside_a_strain_is_its_unit(head: str, factor: float) -> None:
    assert strained(head) == pytest.approx(1.0 + 2.5 * factor)


@pytest.mark.parametrize(
    ("heads", "twin"),
    [
        ("Dehnung log. [%],Spannung wahr [MPa]", "true strain [%],true stress [MPa]"),
        ("epsilon_true,sigma_true (MPa)", "true strain [-],true stress [MPa]"),
        ("Natural strain (-),Stress (MPa)", "true strain [-],stress [MPa]"),
    ],
)
def test_a_true_strain_and_a_true_stress_are_known_wherever_the_measure_stands(heads: str, twin: str) -> None:
    rows = "0.1,0.1\n0.2,0.3\n"
    one, other = (read_tests(f"{head}\n{rows}".encode(), "a.csv", test="uniaxial")[0] for head in (heads, twin))
    assert (one.stretch.tobytes(), one.stress.tobytes()) == (other.stretch.tobytes(), other.stress.tobytes())


def test_of_a_true_stress_no_nominal_one_is_proposed() -> None:
    with pytest.raises(InputError, match=r"sigB_true \[MPa\]=true stress \[MPa\]"):
        read_tests(b"strain,sigB_true [MPa]\n0.1,0.1\n0.2,0.3\n", "a.csv", test="uniaxial")


def test_a_stretch_in_per_cent_that_is_a_strain_is_one_in_per_cent() -> None:
    text = b"# test: tensile\nStretch (%),Stress (MPa)\n5,0.1\n20,0.3\n"
    with pytest.raises(InputError, match="is it a strain") as caught:
        read_tests(text, "a.csv")
    told = layout([re.findall(r'--columns "([^"]*)"', str(caught.value))[0]])
    assert read_tests(text, "a.csv", columns=told)[0].stretch.tolist() == pytest.approx([1.05, 1.2])
    [whole] = read_tests(text.replace(b"\n5,", b"\n105,").replace(b"\n20,", b"\n120,"), "a.csv")
    assert whole.stretch.tolist() == pytest.approx([1.05, 1.2])


@pytest.mark.parametrize("head", ["Strain (%/100)", "Strain (me)"])
def test_what_may_or_may_not_be_the_unit_of_a_strain_is_asked_for(head: str) -> None:
    with pytest.raises(InputError, match="is no unit that is known"):
        strained(head)


@pytest.mark.parametrize(
    "text",
    [
        "Extension,Load\n10 mm,2 N\n20 mm,4 N\n",
        "Extension\tLoad\n10mm\t2N\n20mm\t4N\n",
        "Extension;Load\n10,0 mm;2,0 N\n20,0 mm;4,0 N\n",
        "Extension,Load [N]\n1 cm,2\n2 cm,4\n",
    ],
)
def test_units_in_cells_are_read_below_a_preamble(text: str) -> None:
    mark = ";" if ";" in text else "\t" if "\t" in text else ","
    sizes = [("Batch", f"7{mark}8"), ("Width", "50 mm"), ("Thickness", "0.8 mm"), ("Gauge length", "100 mm")]
    above = "Tensile test\n" + "".join(f"{name}{mark}{value}\n" for name, value in sizes)
    [found] = read_tests((above + text).encode(), "a.csv")
    assert found.stretch.tolist() == pytest.approx([1.1, 1.2])
    assert found.stress.tolist() == pytest.approx([0.05, 0.1])


def test_a_column_in_two_units_is_told_by_both_lines() -> None:
    text = "Tensile test\nGauge length,100 mm\nWidth,50 mm\nExtension,Load,Remark\n1 mm,702 mN,5 N\n2 mm,1.4 N,3 mm\n"
    with pytest.raises(InputError, match=r'line 5, column "Load": 702 mN is in another unit than 1.4 N in line 6'):
        read_tests(text.encode(), "a.csv")
    [found] = read_tests(text.replace("702 mN", "0.7 N").encode(), "a.csv")
    assert found.stress.tolist() == pytest.approx([0.014, 0.028])


@pytest.mark.parametrize("strain", ["ε_t", "εt", "eps_t", "ε_T", "ε_t [%]", "e_true", "eps_true", "ε_ln", "ln_strain"])
@pytest.mark.parametrize("stress", ["σ_t [MPa]", "sigma_true [MPa]"])
def test_a_letter_of_a_true_strain_makes_the_stress_beside_it_true(strain: str, stress: str) -> None:
    many = 100.0 if "%" in strain else 1.0
    rows = "".join(f"{many * np.log(one)},{one * 0.2}\n" for one in (1.1, 1.6))
    [found] = read_tests(f"# test: uniaxial\n{strain},{stress}\n{rows}".encode(), "a.csv")
    assert found.stretch.tolist() == pytest.approx([1.1, 1.6])
    assert found.stress.tolist() == pytest.approx([0.2, 0.2])


def test_a_strain_of_the_letter_t_beside_another_may_be_across() -> None:
    rows = "0.1,-0.05,0.2\n0.2,-0.09,0.4\n"
    [found] = read_tests(f"# test: uniaxial\nε_a,ε_t,σ [MPa]\n{rows}".encode(), "a.csv")
    assert (found.stretch.tolist(), found.stress.tolist()) == ([1.1, 1.2], [0.2, 0.4])
    with pytest.raises(InputError, match="no column gives a stretch"):
        read_tests(f"# test: uniaxial\nε_l [-],ε_t [-],σ [MPa]\n{rows}".encode(), "a.csv")


@pytest.mark.parametrize("cells", ["10 mm,2 N\n20 mm,4 N\n", "A,10 mm,2 N\nA,20 mm,4 N\n"])
def test_units_in_cells_beside_another_unit_in_the_head_are_refused(cells: str) -> None:
    name = "Specimen," if "A" in cells else ""
    text = "Tensile test\nWidth,50,mm\nGauge length,100,mm\n" + name + "Extension{},Load{}\n" + cells
    assert read_tests(text.format("", "").encode(), "a.csv")[0].stress.tolist() == pytest.approx([0.04, 0.08])
    with pytest.raises(InputError, match=r'line 5, column "Load \[kN\]": 2 N is in another unit than the head'):
        read_tests(text.format("", " [kN]").encode(), "a.csv")


@pytest.mark.parametrize("head", ["ε_eng,σ_eng [MPa],ε_t,σ_t [MPa]", "ε_t,σ_t [MPa],ε_eng,σ_eng [MPa]"])
def test_of_engineering_and_true_readings_one_pair_is_taken(head: str) -> None:
    nominal = ["0.1,0.2", "0.2,0.4"]
    true = ["0.0953101798,0.22", "0.1823215568,0.48"]
    pairs = zip(nominal, true, strict=True) if head.startswith("ε_eng") else zip(true, nominal, strict=True)
    rows = "".join(",".join(pair) + "\n" for pair in pairs)
    [found] = read_tests(f"# test: uniaxial\n{head}\n{rows}".encode(), "a.csv")
    assert (found.stretch.tolist(), found.stress.tolist()) == (pytest.approx([1.1, 1.2]), [0.2, 0.4])


def test_a_row_of_units_that_gainsays_the_head_below_a_preamble_is_refused() -> None:
    text = "Tensile test\nWidth,50,mm\nThickness,0.8,mm\nStrain (%),Stress (MPa)\n%,{}\n10,2\n20,4\n"
    with pytest.raises(InputError, match=r'column "Stress \(MPa\)": MPa or kPa is no unit'):
        read_tests(text.format("kPa").encode(), "a.csv")
    assert read_tests(text.format("N/mm^2").encode(), "a.csv")[0].stress.tolist() == [2.0, 4.0]


def test_a_stress_of_the_letter_t_beside_an_engineering_strain_is_asked_for() -> None:
    text = "# test: uniaxial\nstrain [%],σ_t [MPa]\n10,0.22\n20,0.48\n".encode()
    with pytest.raises(InputError, match="a true stress, or a tensile one") as caught:
        read_tests(text, "a.csv")
    true, nominal = (
        read_tests(text, "a.csv", columns=layout([option]))[0].stress.tolist()
        for option in re.findall(r'--columns "([^"]*)"', str(caught.value))
    )
    assert (true, nominal) == (pytest.approx([0.2, 0.4]), [0.22, 0.48])


@pytest.mark.parametrize(
    "heads",
    [
        "压缩应变 (位移) (%),压缩应力 (MPa)",
        "圧縮ひずみ (%),圧縮応力 (MPa)",
        "деформация сжатия (%),напряжение сжатия (MPa)",
    ],
)
def test_a_compression_is_one_in_other_scripts_too(heads: str) -> None:
    text = f"# test: uniaxial\n{heads}\n10,0.2\n20,0.5\n30,0.9\n"
    [found] = read_tests(text.encode(), "a.csv")
    assert found.stretch.tolist() == pytest.approx([0.9, 0.8, 0.7])
    assert found.stress.tolist() == pytest.approx([-0.2, -0.5, -0.9])


@pytest.mark.parametrize("head", ["AVE 2 (%)", "AVE2 (%)", "AVE1 (%)", "AVE (%)"])
def test_a_strain_of_a_video_extensometer_goes_before_the_way_of_the_grips(head: str) -> None:
    """The number is that of its model, no axis."""
    text = f"# test: uniaxial\nDisplacement (mm),Stress (MPa),{head}\n1,0.2,10\n2,0.5,20\n3,0.9,30\n"
    [found] = read_tests(text.encode(), "a.csv")
    assert found.stretch.tolist() == pytest.approx([1.1, 1.2, 1.3])


@pytest.mark.parametrize(
    "heads",
    [
        "Crosshead (mm),Extensometer strain (%)",
        "Crosshead strain (%),Video strain (%)",
        "Machine strain (%),Strain (extensometer) (%)",
        "Crosshead displacement (mm),Video axial strain (%)",
        "Standardweg (mm),Feindehnung (%)",
    ],
)
def test_what_reads_the_specimen_itself_goes_before_the_machine(heads: str) -> None:
    [found] = read_tests(f"{STRIP}{heads},Load (N)\n12,10,2\n24,20,4\n".encode(), "a.csv")
    assert found.stretch.tolist() == pytest.approx([1.1, 1.2])


def test_a_second_column_of_the_same_that_is_not_taken_is_told() -> None:
    [found] = read_tests(
        f"{STRIP}Machine strain (%),Extensometer strain (%),Load (N)\n12,10,2\n24,20,4\n".encode(), "a"
    )
    assert "columns not used: Machine strain (%)" in found.notes


@pytest.mark.parametrize(
    "heads",
    [
        "Traverse (mm),Feindehnung (mm)",
        "Crosshead (mm),Extensometer elongation (mm)",
        "Crosshead (mm),Laser extensometer (mm)",
        "Crosshead (mm),Clip-on extensometer (mm)",
        "C_1_Déplacement[mm],C_1_Déform1[mm]",
    ],
)
def test_an_elongation_of_an_extensometer_beside_that_of_the_machine_is_asked_about(heads: str) -> None:
    with pytest.raises(InputError, match="two columns give the extension"):
        read_tests(f"{STRIP}{heads},Load (N)\n12,5,2\n24,10,4\n".encode(), "a.csv")


def test_cycles_that_are_counted_in_parts_are_whole_ones_done() -> None:
    head = "# test: uniaxial\nstrain [%],stress [MPa],Cycle count\n"
    [found] = read_tests(f"{head}1,0.1,0\n2,0.2,0\n1,0.1,0.5\n1,0.1,1\n2,0.2,1.25\n".encode(), "a.csv")
    assert found.cycle is not None
    assert found.cycle.tolist() == [0, 0, 0, 1, 1]
    with pytest.raises(InputError, match="no cycle number"):
        read_tests(f"{head}1,0.1,0\n2,0.2,0.1\n3,0.3,0.2\n".encode(), "a.csv")


@pytest.mark.parametrize(("scale", "unit"), [(1e6, "Pa"), (1.0, "MPa")])
def test_a_stress_without_a_unit_is_proposed_in_the_one_it_can_have(scale: float, unit: str) -> None:
    rows = "".join(f"{0.1 * k:.1f},{scale * 0.05 * k:.4g}\n" for k in range(1, 9))
    with pytest.raises(InputError) as caught:
        read_tests(f"# test: uniaxial\nstrain,stress\n{rows}".encode(), "a.csv")
    assert f'as in "stress [{unit}]", or say --columns "stress=stress [{unit}]"' in str(caught.value)
    [found] = read_tests(
        f"# test: uniaxial\nstrain,stress\n{rows}".encode(), "a.csv", columns=layout([f"stress=stress [{unit}]"])
    )
    assert found.stress.max() == pytest.approx(0.4)


@pytest.mark.parametrize(("load", "newtons"), [("force_n", 1.0), ("load_kn", 1000.0), ("force_cn", 0.01)])
def test_units_in_small_letters_behind_a_name_are_known_by_what_it_measures(load: str, newtons: float) -> None:
    assert pulled(load).stress.tolist() == pytest.approx([2 * N * newtons, 4 * N * newtons])
    text = "strain_pct,stress_kpa,temperature_c\n0,0,60\n10,500,60\n"
    [found] = read_tests(text.encode(), "a.csv", test="uniaxial")
    assert found.stress.tolist() == [0.0, 0.5]
    assert found.temperature_degC is not None
    assert found.temperature_degC.tolist() == [60.0, 60.0]
    with pytest.raises(InputError, match="force_q"):
        pulled("force_q")


def test_the_sign_of_typesetters_is_a_minus() -> None:
    text = "# test: tensile\nstrain [%],stress [MPa]\n\u22121,\u22120.01\n0,0\n10,0.1\n"
    [found] = read_tests(text.encode(), "a.csv")
    assert (found.stretch[0], found.stress[0]) == (0.99, -0.01)


@pytest.mark.parametrize("page", ["utf-8", "cp1254"])
def test_turkish_heads_and_sizes_are_read_in_their_code_page(page: str) -> None:
    sizes = "Geni\u015flik;50;mm\nNumune kal\u0131nl\u0131\u011f\u0131;0,8;mm\n\u00d6l\u00e7\u00fc boyu;100;mm\n"
    heads = "Y\u00f6n;Atk\u0131\nS\u00fcre (s);Uzama (mm);Kuvvet (N)\n"
    text = f"\u00c7ekme testi;TS EN ISO 13934-1\n{sizes}{heads}0,0;0,0;0,0\n1,0;10,0;2,0\n"
    [found] = read_tests(text.encode(page), "a.csv")
    assert (found.direction, found.stretch[1]) == (90.0, 1.1)
    assert found.stress[1] == pytest.approx(2 * N)


POLISH = (
    "Próba rozciągania;PN-EN ISO 13934-1\nSzerokość próbki;50;mm\nGrubość;0,8;mm\nDługość pomiarowa;100;mm\n"
    "Kierunek;wątek\nCzas [s];Wydłużenie [mm];Siła [N]\n"
)
DUTCH = (
    "Trekproef;NEN-EN ISO 13934-1\nBreedte;50;mm\nDikte;0,8;mm\nMeetlengte;100;mm\nRichting;inslag\n"
    "Tijd [s];Verlenging [mm];Kracht [N]\n"
)


@pytest.mark.parametrize(("page", "above"), [("utf-8", POLISH), ("cp1250", POLISH), ("cp1252", DUTCH)])
def test_polish_and_dutch_heads_and_sizes_are_read(page: str, above: str) -> None:
    [found] = read_tests(f"{above}0,0;0,0;0,0\n1,0;10,0;2,0\n".encode(page), "a.csv")
    assert (found.direction, found.stretch[1]) == (90.0, 1.1)
    assert found.stress[1] == pytest.approx(2 * N)


def test_chinese_sizes_are_read() -> None:
    sizes = "\u8bd5\u6837\u5bbd\u5ea6,50,mm\n\u8bd5\u6837\u539a\u5ea6,0.8,mm\n\u539f\u59cb\u6807\u8ddd,100,mm\n"
    heads = "\u65b9\u5411,\u7eac\u5411\n\u65f6\u95f4(s),\u4f4d\u79fb(mm),\u529b(N)\n"
    text = f"\u8bd5\u9a8c\u540d\u79f0,\u62c9\u4f38\u8bd5\u9a8c\n{sizes}{heads}0,0,0\n1,10,2\n"
    [found] = read_tests(text.encode("gb18030"), "a.csv")
    assert (found.direction, found.stress[1]) == (90.0, pytest.approx(2 * N))
