"""One pull of a strip as testing machines and offices write it: builders of whole files from the plain readings.

Each follows how the machine or program is known to export: Instron Bluehill 2, 3 and Universal, ZwickRoell testXpert
II and III, MTS TestWorks and TestSuite, Shimadzu Trapezium, Mark-10, Textechno Statimat, image correlation, numpy,
pandas, Excel in several languages.
"""

from __future__ import annotations

import io
import zipfile
from decimal import Decimal
from xml.sax.saxutils import escape

#: Strain and nominal stress [MPa] of the pull, as decimal text: exact in every unit the exports use.
PULL = [
    ("0.05", "0.0625"),
    ("0.1", "0.125"),
    ("0.15", "0.1875"),
    ("0.2", "0.28125"),
    ("0.25", "0.375"),
    ("0.3", "0.5"),
    ("0.35", "0.65625"),
    ("0.4", "0.875"),
    ("0.45", "1.125"),
    ("0.5", "1.5"),
]
#: The strip: gauge length, width and thickness [mm]; stress times section is a force in N, exactly.
LENGTH, WIDTH, THICKNESS = 100, 50, "0.5"


def shifted(text: str, places: int) -> str:
    """Return decimal text times ten to the power ``places``, without rounding."""
    value = Decimal(text).scaleb(places)
    return f"{value.normalize():f}"


def times(text: str, factor: int) -> str:
    return f"{(Decimal(text) * factor).normalize():f}"


def plain() -> str:
    return "# test: uniaxial\nstretch [-],stress [MPa]\n" + "".join(f"{1 + float(e):g},{s}\n" for e, s in PULL)


def plain_strain() -> str:
    return "# test: uniaxial\nstrain [-],stress [MPa]\n" + "".join(f"{e},{s}\n" for e, s in PULL)


def plain_force() -> str:
    head = f"# test: uniaxial\n# gauge length: {LENGTH} mm\n# width: {WIDTH} mm\n# thickness: {THICKNESS} mm\n"
    return head + "extension [mm],force [N]\n" + "".join(f"{x},{f}\n" for x, f in raw())


def raw() -> list[tuple[str, str]]:
    """Extension [mm] and force [N]."""
    return [(shifted(e, 2), times(s, 25)) for e, s in PULL]


def comma(text: str) -> str:
    return text.replace(".", ",")


def joined(lines: list[str], ends: str = "\r\n") -> str:
    return ends.join([*lines, ""])


def workbook(sheets: dict[str, list[list[object]]], percent: frozenset[tuple[int, int]] = frozenset()) -> bytes:
    """Return an .xlsx of rows of cells: text, numbers (decimal text in a 1-tuple), None; some in per cent."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as book:
        book.writestr(
            "[Content_Types].xml",
            '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"/>',
        )
        names = "".join(f'<sheet name="{escape(n)}" sheetId="{k}" r:id="rId{k}"/>' for k, n in enumerate(sheets, 1))
        book.writestr("xl/workbook.xml", f'<workbook xmlns:r="r"><sheets>{names}</sheets></workbook>')
        links = "".join(
            f'<Relationship Id="rId{k}" Target="worksheets/sheet{k}.xml"/>' for k in range(1, len(sheets) + 1)
        )
        book.writestr("xl/_rels/workbook.xml.rels", f"<Relationships>{links}</Relationships>")
        book.writestr(
            "xl/styles.xml",
            '<styleSheet><cellXfs><xf numFmtId="0"/><xf numFmtId="10"/></cellXfs></styleSheet>',
        )
        texts: list[str] = []
        for k, rows in enumerate(sheets.values(), 1):
            body = []
            for r, row in enumerate(rows, 1):
                cells = []
                for c, cell in enumerate(row):
                    place = f"{chr(65 + c)}{r}"
                    if cell is None:
                        continue
                    if isinstance(cell, tuple):
                        style = ' s="1"' if (r, c) in percent else ""
                        cells.append(f'<c r="{place}"{style}><v>{cell[0]}</v></c>')
                    elif str(cell).startswith("#"):
                        cells.append(f'<c r="{place}" t="e"><v>{cell}</v></c>')
                    else:
                        texts.append(str(cell))
                        cells.append(f'<c r="{place}" t="s"><v>{len(texts) - 1}</v></c>')
                body.append(f'<row r="{r}">{"".join(cells)}</row>')
            book.writestr(
                f"xl/worksheets/sheet{k}.xml",
                f"<worksheet><sheetData>{''.join(body)}</sheetData></worksheet>",
            )
        strings = "".join(f"<si><t>{escape(text)}</t></si>" for text in texts)
        book.writestr("xl/sharedStrings.xml", f"<sst>{strings}</sst>")
    return stream.getvalue()


def bluehill2() -> bytes:
    lines = [
        '"Specimen label","A-1"',
        '"Test Method","Tensile fabric strip"',
        f'"Width","{WIDTH}","mm"',
        f'"Thickness","{THICKNESS}","mm"',
        f'"Gauge length","{LENGTH}","mm"',
        "",
        '"Time (s)","Extension (mm)","Load (N)"',
    ]
    lines += [f'"{k / 10:.4f}","{x}","{f}"' for k, (x, f) in enumerate(raw())]
    return joined(lines).encode()


def bluehill3_spanish() -> bytes:
    lines = [
        "Instron Bluehill 3.75;;;",
        "Operador;J. Perez;;",
        "Empresa;Tejidos S.A.;;",
        "Ensayo;Tracción;;",
        f"Ancho;{WIDTH},00;mm;",
        f"Espesor;{comma(THICKNESS)}0;mm;",
        f"Longitud inicial;{LENGTH},0;mm;",
        "Temperatura;23,0;°C;",
        "Dirección;urdimbre;;",
        "",
        "Tiempo;Extensión;Carga;Ciclo",
        "(s);(mm);(N);",
    ]
    lines += [f"{comma(str(k))};{comma(x)};{comma(f)};1" for k, (x, f) in enumerate(raw())]
    return joined(lines).encode("cp1252")


def bluehill_universal() -> bytes:
    lines = [
        "Results Table 1",
        ",Maximum Load,Tensile strain at Break",
        ",(N),(%)",
        "1,37.5,50",
        "Mean,37.5,50",
        "",
        "",
        "Time,Displacement,Force,Tensile strain (Displacement),Tensile stress",
        "(s),(mm),(N),(%),(MPa)",
    ]
    lines += [
        f'"{k}","{x}","{f}","{shifted(e, 2)}","{s}"' for k, ((x, f), (e, s)) in enumerate(zip(raw(), PULL, strict=True))
    ]
    return joined(lines).encode("utf-8-sig")


def testxpert2() -> bytes:
    lines = [
        '"Prüfer";"M. Weiß"',
        '"Prüfvorschrift";"Zugversuch EN ISO 13934-1"',
        f'"Probendicke a0";"{comma(THICKNESS)}";"mm"',
        f'"Probenbreite b0";"{WIDTH}";"mm"',
        f'"Einspannlänge LE";"{LENGTH}";"mm"',
        '"Prüfrichtung";"Kette"',
        '"Prüfzeit";"Standardweg";"Standardkraft"',
        '"s";"mm";"N"',
    ]
    lines += [f'"{comma(f"{k / 10}")}";"{comma(x)}";"{comma(f)}"' for k, (x, f) in enumerate(raw())]
    return joined(lines).encode("cp1252")


def testxpert3_sheets() -> bytes:
    rows: list[list[object]] = [["Dehnung", "Zugspannung"], ["%", "MPa"]]
    rows += [[(shifted(e, 2),), (s,)] for e, s in PULL]
    return workbook({"Ergebnisse": [["Nr", "Fmax"], [None, "N"], [("1",), ("37.5",)]], "Probe 1": rows})


def testworks() -> bytes:
    lines = [
        "MTS TestWorks 4",
        "Test Run: 12",
        f"Width\t{WIDTH}\tmm",
        f"Thickness\t{THICKNESS}\tmm",
        f"Grip Separation\t{LENGTH}\tmm",
        "",
        "Crosshead \tLoad \tTime",
        "mm \tN \tsec",
    ]
    lines += [f"{x}\t{f}\t{k}" for k, (x, f) in enumerate(raw())]
    return joined(lines).encode()


def testsuite() -> bytes:
    lines = [
        "Data Acquisition: Timed",
        "Station Name: strip.cfg",
        "",
        "Axial Displacement\tAxial Force\tTime",
        "mm\tkN\tSec",
    ]
    lines += [f"{x}\t{shifted(f, -3)}\t{k}" for k, (x, f) in enumerate(raw())]
    return joined(lines).encode()


def trapezium_japanese() -> bytes:
    lines = ['"試験名","引張"', '"時間","試験力","ストローク"', '"sec","N","mm"']
    lines += [f'"{k}","{f}","{x}"' for k, (x, f) in enumerate(raw())]
    return joined(lines).encode("cp932")


def mark10() -> bytes:
    lines = ["MESUR gauge Plus", "Sample Name: A", "", "Reading,Load [kgF],Travel [mm],Time [s]"]
    lines += [f"{k},{float(f) / 9.80665!r},{x},{k / 10}" for k, (x, f) in enumerate(raw(), 1)]
    return joined(lines).encode()


def statimat() -> bytes:
    lines = [
        "Textechno H. Stein GmbH & Co. KG",
        "STATIMAT ME+",
        f"Einspannlänge: {LENGTH} mm",
        "Nr.;Dehnung [%];Kraft [cN]",
    ]
    lines += [
        f"{k};{comma(shifted(e, 2))};{comma(shifted(f, 2))}"
        for k, ((_, f), (e, _)) in enumerate(zip(raw(), PULL, strict=True), 1)
    ]
    return joined(lines).encode("cp1252")


def image_correlation() -> bytes:
    return joined(
        [
            "index lambda_x [-] sigma_xx [MPa]",
            *(f"{k} {1 + float(e):g} {s}" for k, (e, s) in enumerate(PULL)),
        ],
        "\n",
    ).encode()


def gom() -> bytes:
    lines = ["# GOM Correlate", "Stage;Time [s];Technical strain.Y [%];Force [N]"]
    lines[1] = "Stage;Time [s];e_yy [%];Force [N]"
    return joined(
        lines + [f"{k};{k};{shifted(e, 2)};{f}" for k, ((_, f), (e, _)) in enumerate(zip(raw(), PULL, strict=True))]
    ).encode()


def excel_german() -> bytes:
    lines = ["Datum;Uhrzeit;Dehnung [%];Spannung [N/mm²];Bemerkung"]
    lines += [f"22.11.2026;10:00:{k:02d};{comma(shifted(e, 2))};{comma(s)};" for k, (e, s) in enumerate(PULL)]
    return joined([*lines, "Mittelwert;;27,5;0,6;", ";;;;", "Ende der Messung;;;;"]).encode("cp1252")


def excel_french() -> bytes:
    lines = ["Essai de traction", "", "Déformation (%)\tContrainte (MPa)"]
    return joined([*lines, *(f"{comma(shifted(e, 2))} %\t{comma(s)}" for e, s in PULL)]).encode("utf-16")


def excel_italian() -> bytes:
    lines = ["Prova di trazione;;", "Deformazione {%};Sforzo {kPa};Note"]
    return joined(lines + [f"{comma(shifted(e, 2))};{comma(shifted(s, 3))};" for e, s in PULL]).encode("mac_roman")


def excel_portuguese() -> bytes:
    lines = ["Ensaio de tração", "Deformação / %;Tensão / MPa"]
    return joined(
        lines
        + [f"{comma(shifted(e, 2))};{comma(s)}" for e, s in PULL]
        + ["Média;1,0", "Desvio padrão;0,1", "#DIV/0!;#DIV/0!"]
    ).encode("utf-8")


def membrane_in_5cm() -> bytes:
    lines = ["EN ISO 13934-1 strip method", "Elongation (%),Force (N/5cm)"]
    return joined(lines + [f"{shifted(e, 2)},{times(s, 25)}" for e, s in PULL]).encode()


def numpy_savetxt() -> bytes:
    lines = ["# stretch stress_MPa", *(f"{1 + float(e):.18e} {float(s):.18e}" for e, s in PULL)]
    return joined(lines, "\n").encode()


def pandas_copies() -> bytes:
    lines = ["strain,stress [MPa],strain.1,stress [MPa].1"]
    return joined(
        lines + [f"{e},{s},{e},{s}" for e, s in PULL[:-1]] + [f"{PULL[-1][0]},{PULL[-1][1]},,"], "\n"
    ).encode()


def side_by_side() -> bytes:
    lines = ["Probe 1;;Probe 2;", "Dehnung;Spannung;Dehnung;Spannung", "%;MPa;%;MPa"]
    return joined(
        lines + [f"{comma(shifted(e, 2))};{comma(s)};{comma(shifted(e, 2))};{comma(s)}" for e, s in PULL]
    ).encode("cp1252")


def stacked() -> bytes:
    head = ["Dehnung;Spannung", "%;MPa"]
    rows = [f"{comma(shifted(e, 2))};{comma(s)}" for e, s in PULL]
    return joined(["Probe 1;", *head, *rows, "", "Probe 2;", *head, *rows]).encode("cp1252")


def thousands() -> bytes:
    lines = ["Strain (%);Stress (Pa)"]
    return joined(lines + [f'"{shifted(e, 2)}";"{int(shifted(s, 6)):,}"' for e, s in PULL]).encode()


def percent_cells() -> bytes:
    rows: list[list[object]] = [["Tensile test of a strip"], [], ["Strain", "Stress"], [None, "MPa"]]
    rows += [[(e,), (s,)] for e, s in PULL]
    rows += [["Mean", "#DIV/0!"]]
    return workbook({"Sheet1": rows}, frozenset((r, 0) for r in range(5, 15)))


#: Files of other habits, written after the reader was: text, then what it is encoded in.
def others() -> dict[str, bytes]:
    """Return whole files by name: merged cells, two header rows, pivoted rows, odd units, comments, clocks."""
    pull, force = PULL, raw()
    return {
        "merged_title_xlsx": workbook(
            {
                "Tabelle1": [
                    ["Zugversuch Gewebe K17"],
                    ["Kunde", None, "ACME"],
                    [],
                    [None, "Probe 1", None, "Probe 2", None],
                    ["Nr", "Dehnung [%]", "Spannung [MPa]", "Dehnung [%]", "Spannung [MPa]"],
                    *[[(str(k),), (shifted(e, 2),), (s,), (shifted(e, 2),), (s,)] for k, (e, s) in enumerate(pull)],
                ]
            }
        ),
        "two_header_rows": joined(
            [
                "Zeit;Zug;Zug",
                ";Dehnung [%];Spannung [MPa]",
                *[f"{k};{comma(shifted(e, 2))};{comma(s)}" for k, (e, s) in enumerate(pull)],
            ]
        ).encode(),
        "utf16_tab_comma": joined(
            [
                "Dehnung [%]\tKraft [N]",
                *[f"{comma(shifted(e, 2))}\t{comma(f)}" for (e, _), (_, f) in zip(pull, force, strict=True)],
            ]
        ).encode("utf-16"),
        "comments_end": joined(
            [
                "strain [%],stress [MPa]",
                *[f"{shifted(e, 2)},{s}" for e, s in pull],
                "# tested by Jane",
                "* end",
            ]
        ).encode(),
        "semi_spaces": joined(
            [
                "Dehnung ; Spannung",
                "[%] ; [MPa]",
                *[f" {comma(shifted(e, 2))} ; {comma(s)} " for e, s in pull],
            ]
        ).encode(),
        "kN_cm": joined(
            ["Weg [cm];Kraft [kN]", *[f"{comma(shifted(x, -1))};{comma(shifted(f, -3))}" for x, f in force]]
        ).encode(),
        "time_first_specimen_col": joined(
            [
                "Specimen,Time (s),Strain (%),Stress (MPa)",
                *[f"{n},{k},{shifted(e, 2)},{s}" for n in (1, 2) for k, (e, s) in enumerate(pull)],
            ]
        ).encode(),
        "pivot": joined(
            [
                "Strain [%]," + ",".join(shifted(e, 2) for e, _ in pull),
                "Stress [MPa]," + ",".join(s for _, s in pull),
            ]
        ).encode(),
        "shared_strain": joined(
            [
                "Strain [%];Specimen 1 [MPa];Specimen 2 [MPa];Mean [MPa]",
                *[f"{shifted(e, 2)};{s};{s};{s}" for e, s in pull],
            ]
        ).encode(),
        "labview": joined(
            [
                "LabVIEW Measurement\t",
                "Writer_Version\t2",
                "Separator\tTab",
                "Decimal_Separator\t.",
                "***End_of_Header***\t",
                "",
                "Time\tDisplacement (mm)\tForce (N)\tComment",
                *[f"{k}\t{x}\t{f}\t" for k, (x, f) in enumerate(force)],
            ]
        ).encode(),
        "results_then_raw": joined(
            [
                "Summary",
                "Sample;Max force [N];Max elongation [%]",
                "1;37,5;50",
                "2;37,6;51",
                "Average;37,55;50,5",
                "",
                "Raw data",
                "Elongation [%];Force [N]",
                *[f"{comma(shifted(e, 2))};{comma(f)}" for (e, _), (_, f) in zip(pull, force, strict=True)],
            ]
        ).encode(),
        "french_semicolon": joined(
            [
                "Allongement (mm);Effort (N);Temps (s)",
                *[f"{comma(x)};{comma(f)};{k}" for k, (x, f) in enumerate(force)],
            ]
        ).encode("cp1252"),
        "cyrillic": joined(
            ["Деформация [%];Напряжение [MPa]", *[f"{comma(shifted(e, 2))};{comma(s)}" for e, s in pull]]
        ).encode("cp1251"),
        "fixed_width": joined(
            ["  Strain (%)    Stress (MPa)", *[f"{shifted(e, 2):>12}{s:>16}" for e, s in pull]]
        ).encode(),
        "time_clock": joined(
            [
                "Time,Strain (%),Stress (MPa)",
                *[f"00:00:{k:02d}.500,{shifted(e, 2)},{s}" for k, (e, s) in enumerate(pull)],
            ]
        ).encode(),
        "nv_rows": joined(
            [
                "Dehnung [%];Spannung [MPa]",
                *[f"{comma(shifted(e, 2))};{comma(s)}" for e, s in pull[:5]],
                "#NV;#NV",
                *[f"{comma(shifted(e, 2))};{comma(s)}" for e, s in pull[5:]],
            ]
        ).encode(),
        "quoted_units_row": joined(
            ['"Strain","Stress"', '"(%)","(MPa)"', *[f'"{shifted(e, 2)}","{s}"' for e, s in pull]]
        ).encode(),
        "rate_speed": joined(
            [
                "Crosshead speed: 100 mm/min",
                "Gauge length: 100 mm",
                "Width: 50 mm",
                "Thickness: 0.5 mm",
                "Extension (mm),Load (N)",
                *[f"{x},{f}" for x, f in force],
            ]
        ).encode(),
        "lambda_P": joined(["lambda,P_MPa", *[f"{1 + float(e):g},{s}" for e, s in pull]]).encode(),
        "trapezium_stacked_heads": joined(
            [
                "Results",
                "",
                "",
                "1 _ 1",
                "Time,Force,Stroke",
                "sec,N,mm",
                *[f"{k},{f},{x}" for k, (x, f) in enumerate(force)],
            ]
        ).encode(),
        "whitespace_head_words": joined(
            [
                "Time [s]  Tensile strain [%]  Tensile stress [MPa]",
                *[f"{k}  {shifted(e, 2)}  {s}" for k, (e, s) in enumerate(pull)],
            ]
        ).encode(),
        "decimal_comma_ws": joined(
            ["Dehnung[%] Spannung[MPa]", *[f"{comma(shifted(e, 2))} {comma(s)}" for e, s in pull]]
        ).encode(),
        "units_in_angles": joined(
            [
                "Strain;Force;Time",
                "<%>;<N>;<s>",
                *[f"{shifted(e, 2)};{f};{k}" for k, ((e, _), (_, f)) in enumerate(zip(pull, force, strict=True))],
            ]
        ).encode(),
        "excel_text_numbers": workbook(
            {"S": [["Dehnung [%]", "Spannung [MPa]"], *[[comma(shifted(e, 2)), comma(s)] for e, s in pull]]}
        ),
        "istra": joined(
            [
                "sep=;",
                "Step;Time [s];Engineering strain y [%];Analog force [N]",
                *[
                    f"{k};{k};{comma(shifted(e, 2))};{comma(f)}"
                    for k, ((e, _), (_, f)) in enumerate(zip(pull, force, strict=True))
                ],
            ]
        ).encode(),
        "vic": joined(
            [
                '"Index","Count","e1","eyy [-]","Stress [MPa]"',
                *[f"{k},{k},0,{e},{s}" for k, (e, s) in enumerate(pull)],
            ]
        ).encode(),
        "rows_with_units_in_cells": joined(
            ["Strain;Stress", *[f"{shifted(e, 2)} %;{s} MPa" for e, s in pull]]
        ).encode(),
        "pipe": joined(
            ["| Strain (%) | Stress (MPa) |", "|---|---|", *[f"| {shifted(e, 2)} | {s} |" for e, s in pull]]
        ).encode(),
        "line_no_first": joined(
            ["No.;Ext. mm;Load N", *[f"{k};{comma(x)};{comma(f)}" for k, (x, f) in enumerate(force)]]
        ).encode(),
        "unit_after_slash": joined(
            ["s / mm;F / N;t / s", *[f"{comma(x)};{comma(f)};{k}" for k, (x, f) in enumerate(force)]]
        ).encode(),
        "date_time_col": joined(
            [
                "Date Time;Strain (%);Stress (MPa)",
                *[f"2026-11-22 10:00:{k:02d};{shifted(e, 2)};{s}" for k, (e, s) in enumerate(pull)],
            ]
        ).encode(),
        "long_preamble_odd_clock": joined(
            [f"Parameter {k};{k * 1.5:g}".replace(".", ",") for k in range(9)]
            + [
                "Testname;strip",
                "Datum;22.11.2026",
                "Geschwindigkeit;100;mm/min",
                "Probe;A7",
                "",
                "Zeit;Weg;Kraft",
                "s;mm;N",
                *[f"{k // 10},{k % 10};{comma(x)};{comma(f)}" for k, (x, f) in enumerate(force, 5)],
            ]
        ).encode("cp1252"),
    }


def undecided() -> dict[str, bytes]:
    """Return whole files that can be read in several ways, by name."""
    pull, force = PULL, raw()
    return {
        "headerless": joined([f"{1 + float(e):g} {s}" for e, s in pull]).encode(),
        "headerless_csv": joined([f"{1 + float(e):g},{s}" for e, s in pull]).encode(),
        "unknown_words": joined(["Kanal A;Kanal B", *[f"{1 + float(e):g};{s}" for e, s in pull]]).encode(),
        "no_units": joined(["Extension,Load", *[f"{x},{f}" for x, f in force]]).encode(),
        "two_forces": joined(
            ["Weg [mm];Kraft 1 [N];Kraft 2 [N]", *[f"{x};{f};{times(f, 2)}" for x, f in force]]
        ).encode(),
        "two_forces_b": joined(
            ["Weg [mm];Kraft [N];Standardkraft [N]", *[f"{x};{f};{times(f, 2)}" for x, f in force]]
        ).encode(),
        "temp_nounit": joined(
            ["strain [%],stress [MPa],temp", *[f"{shifted(e, 2)},{s},293" for e, s in pull]]
        ).encode(),
        "exx_eyy": joined(
            [
                "eps_x,eps_y,F [N]",
                *[f"{-0.3 * float(e):.4f},{e},{f}" for (e, _), (_, f) in zip(pull, force, strict=True)],
            ]
        ).encode(),
        "dollar_title": joined(["a$1;b`2", *[f"{1 + float(e):g};{s}" for e, s in pull]]).encode(),
    }
