"""More habits of machines and offices, for the pull of ``machine_exports``: whole files by name."""

from __future__ import annotations

from decimal import Decimal

from machine_exports import PULL, comma, joined, raw, shifted, times, workbook

#: Readings in the units most exports have: per cent, MPa, mm, N.
PERCENT = [(shifted(strain, 2), stress) for strain, stress in PULL]
FORCE = raw()


def grouped(text: str, thousands: str, mark: str) -> str:
    """Return millinewtons of newtons with their thousands set apart."""
    value = f"{Decimal(times(text, 1000)):,.3f}"
    return value.replace(",", "\0").replace(".", mark).replace("\0", thousands)


def table(head: str, rows: list[tuple[object, ...]], mark: str = ",", end: str = "") -> str:
    return joined([head, *[mark.join(map(str, row)) + end for row in rows]])


def office() -> dict[str, bytes]:
    """Files that are read as they are."""
    strain, force = PERCENT, FORCE
    timed = [(k, x, f) for k, (x, f) in enumerate(force)]
    german = [(comma(e), comma(s)) for e, s in strain]
    return {
        "chinese": table("序号,时间(s),位移(mm),力(N)", [(k, *row) for k, row in enumerate(timed)]).encode("gb18030"),
        "centinewton_behind_names": table(
            "Elongation mm\tForce cN", [(x, times(f, 100)) for x, f in force], "\t"
        ).encode(),
        "capitals": table("EXTENSION (MM),LOAD (N),TIME (SEC)", [(x, f, k) for k, x, f in timed]).encode(),
        "kilopascal": table(
            "Engineering Strain (mm/mm),Engineering Stress (kPa)", [(e, shifted(s, 3)) for e, s in PULL]
        ).encode(),
        "results_before": joined(
            [
                '"Results Table 1"',
                '"","Maximum Load (N)","Width (mm)","Thickness (mm)"',
                '"1","37.5","50.00","0.50"',
                '"Mean","37.5","50.00","0.50"',
                "",
                '"Specimen 1"',
                '"Time","Extension","Load","Tensile strain","Tensile stress"',
                '"(s)","(mm)","(N)","(%)","(MPa)"',
                *[f'"{k}","{x}","{f}","{e}","{s}"' for (k, x, f), (e, s) in zip(timed, strain, strict=True)],
            ]
        ).encode(),
        "one_head_two_specimens": joined(
            [
                "Extension (mm),Load (N)",
                "Specimen 1,",
                *[f"{x},{f}" for x, f in force],
                "Specimen 2,",
                *[f"{x},{f}" for x, f in force],
            ]
        ).encode(),
        "blank_columns": table("Dehnung [%];;Spannung [MPa];;", [(e, "", s) for e, s in german], ";", ";;").encode(),
        "comma_at_the_end": joined(
            ["Specimen 1,,,", "Time,Extension,Load,", "s,mm,N,", *[f"{k},{x},{f}," for k, x, f in timed]]
        ).encode(),
        "units_called_so": joined(
            ["Name,Time,Extension,Load", "Unit,s,mm,N", *[f"{k},{k},{x},{f}" for k, x, f in timed]]
        ).encode(),
        "thousands_swiss": table("Weg [mm];Kraft [mN]", [(x, grouped(f, "'", ".")) for x, f in force], ";").encode(),
        "thousands_blank": table(
            "Weg [mm];Kraft [mN]", [(comma(x), grouped(f, " ", ",")) for x, f in force], ";"
        ).encode(),
        "thousands_narrow": table(
            "Déplacement (mm);Force (mN)", [(comma(x), grouped(f, "\u202f", ",")) for x, f in force], ";"
        ).encode(),
        "thousands_quoted": table(
            '"Extension (mm)","Load (mN)"', [(x, f'"{grouped(f, ",", ".")}"') for x, f in force]
        ).encode(),
        "statistics": table("strain [%],stress [MPa]", [*strain, ("Max", "1.5"), ("CV %", "84")]).encode(),
        "statistics_of_other_words": table(
            "Rek [%];Spanning [MPa]".replace("Rek", "Dehnung").replace("Spanning", "Spannung"),
            [*german, ("Gemiddelde", "0,57"), ("Standardabw.", "0,48"), ("Ortalama", "25,3")],
            ";",
        ).encode(),
        "titles_broken_in_lines": (
            '"Tensile\nstrain (%)","Tensile\nstress (MPa)"\n' + "".join(f"{e},{s}\n" for e, s in strain)
        ).encode(),
        "titles_broken_in_a_workbook": workbook(
            {
                "S": [
                    ["Tensile\nstrain\n(%)", "Tensile stress\n(MPa)"],
                    *[[(e,), (s,)] for e, s in strain],
                ]
            }
        ),
        "numbers_as_formulas": table("Strain [%],Stress [MPa]", [(f'="{e}"', f'="{s}"') for e, s in strain]).encode(),
        "rheometer_that_pulls": (
            "Project:\tFabric\r\nTest:\tTension 1\r\n\r\nInterval and data points:\t1\t10\r\n"
            "Interval data:\tPoint No.\tTime\tGap\tNormal Force\r\n\t\t\t\t\r\n\t\t[s]\t[mm]\t[N]\r\n"
            + "".join(f"\t{k}\t{k}\t{100 + Decimal(x)}\t-{f}\r\n" for k, x, f in timed)
        ).encode("utf-16"),
        "two_channels_one_empty": table(
            "Load (N),Machine Extension (mm),Load (N) filtered", [(f, x, "") for x, f in force]
        ).encode(),
        "distance": table("Force (N),Distance (mm),Time (sec)", [(f, x, k) for k, x, f in timed]).encode(),
        "micrometres": table("Verformung µm;Kraft N", [(times(x, 1000), comma(f)) for x, f in force], ";").encode(
            "cp1252"
        ),
        "image_correlation": table(
            "Frame,eyy,Load [N]",
            [(k, e, f) for k, ((e, _), (_, f)) in enumerate(zip(PULL, force, strict=True))],
        ).encode(),
        "matlab": joined(
            ["% Tensile test, strip", "% strain [-]  stress [MPa]", *[f"{e} {s}" for e, s in PULL]]
        ).encode(),
        "ruled": joined(
            ["Strain    Stress", "(%)       (MPa)", "--------  --------", *[f"{e:<10}{s}" for e, s in strain]]
        ).encode(),
        "sections": joined(
            [
                "[Header]",
                "GaugeLength=100 mm",
                "Width=50 mm",
                "Thickness=0.5 mm",
                "[Data]",
                "Extension (mm),Load (N)",
                *[f"{x},{f}" for x, f in force],
            ]
        ).encode(),
        "sheets_results_first": workbook(
            {
                "Parameters": [["Width", ("50",), "mm"], ["Thickness", ("0.5",), "mm"]],
                "Results": [["No", "Fmax [N]", "eps max [%]"], [("1",), ("37.5",), ("50",)]],
                "Values": [
                    ["Strip", None, None],
                    ["Time", "Strain", "Stress"],
                    ["s", "%", "MPa"],
                    *[[(str(k),), (e,), (s,)] for k, (e, s) in enumerate(strain)],
                ],
            }
        ),
        "per_centimetre": table(
            "Dehnung [%];Kraft [N/cm]", [(comma(e), comma(times(s, 5))) for e, s in strain], ";"
        ).encode(),
        "clock_beside_date": table(
            "Date;Time;Elongation (%);Force (N)",
            [
                ("22.11.2026", f"10:00:{k:02d}", comma(e), comma(f))
                for k, ((e, _), (_, f)) in enumerate(zip(strain, force, strict=True))
            ],
            ";",
        ).encode(),
        "old_line_ends": joined(["strain [%],stress [MPa]", *[f"{e},{s}" for e, s in strain]], "\r").encode(),
        "portuguese": table(
            "Força (N);Deslocamento (mm);Tempo (s)",
            [
                *[(comma(f), comma(x), k) for k, x, f in timed],
                ("Média", "25,3", ""),
                ("Desvio padrão", "12", ""),
            ],
            ";",
        ).encode("latin-1"),
        "polish": table(
            "Czas [s];Wydłużenie [mm];Siła [N]", [(k, comma(x), comma(f)) for k, x, f in timed], ";"
        ).encode("cp1250"),
        "finnish": table(
            "Aika (s);Venym\u00e4 (mm);Voima (N)", [(k, comma(x), comma(f)) for k, x, f in timed], ";"
        ).encode("cp1252"),
        "korean": table("시간(초),변위(mm),하중(N)", [(k, *row) for k, row in enumerate(force)]).encode("utf-8-sig"),
        "czech": table(
            "Čas [s];Prodloužení [mm];Síla [N]", [(k, comma(x), comma(f)) for k, x, f in timed], ";"
        ).encode(),
        "dutch": table("Tijd (s);Rek (%);Spanning (MPa)", [(k, *row) for k, row in enumerate(german)], ";").encode(),
    }


def to_settle() -> dict[str, bytes]:
    """Files that are refused with the option that settles them."""
    strain, force = PERCENT, FORCE
    timed = [(k, comma(x), comma(f)) for k, (x, f) in enumerate(force)]
    return {
        "hungarian": table("Idő (s);Megnyúlás (mm);Erő (N)", timed, ";").encode(),
        "thai": table("เวลา(วินาที),ระยะ(mm),แรง(N)", [(k, *row) for k, row in enumerate(force)]).encode("utf-8-sig"),
        "strain_in_two_units": table(
            "Strain (%),Strain (mm/mm),Stress (MPa)",
            [(p, e, s) for (p, _), (e, s) in zip(strain, PULL, strict=True)],
        ).encode(),
        "volts": table("Kanal 1 [V];Kanal 2 [V]", [(f"{1 + float(e):g}", s) for e, s in PULL], ";").encode(),
        "either_axis": table(
            "Frame,exx,eyy,Load [N]",
            [(k, f"{-0.3 * float(e):.4f}", e, f) for k, ((e, _), (_, f)) in enumerate(zip(PULL, force, strict=True))],
        ).encode(),
    }
