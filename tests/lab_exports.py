"""A third round of exports, written after the reader had read the others: whole files by name, as their machines write.

Instron Bluehill in German, Italian, Portuguese and Spanish, ZwickRoell testXpert III, MTS TestSuite TW Elite, Shimadzu
Trapezium X, Lloyd NEXYGEN, Tinius Olsen, Galdabini, TA TRIOS, GOM Aramis, VIC-3D, Dantec, a Fortran program.
"""

from __future__ import annotations

from decimal import Decimal

from machine_exports import LENGTH, PULL, THICKNESS, WIDTH, comma, joined, raw, shifted, times, workbook
from office_exports import PERCENT, grouped

FORCE = raw()
#: Number, extension [mm], force [N], strain [%], stress [MPa].
ROWS = [(k, x, f, e, s) for k, ((x, f), (e, s)) in enumerate(zip(FORCE, PERCENT, strict=True))]


def fortran(text: str) -> str:
    """Return decimal text as a Fortran program writes a double."""
    mantissa, power = f"{Decimal(text):.6E}".split("E")
    return f"{mantissa}D{int(power):+03d}"


def lagrange(strain: str) -> str:
    """Return Green and Lagrange's strain of an engineering strain, exactly."""
    return f"{Decimal(strain) + Decimal(strain) ** 2 / 2}"


def labs() -> dict[str, bytes]:
    """Files that are read as they are."""
    values = [["Probe 1"], ["Prüfzeit", "Dehnung", "Standardkraft"], ["s", "%", "N"]]
    return {
        "bluehill_german": joined(
            [
                '"Ergebnistabelle 1"',
                '"";"Maximale Kraft [N]";"Zugdehnung bei Bruch [%]"',
                '"1";"37,5";"50,0"',
                '"Standardabweichung";"-----";"-----"',
                "",
                '"Zeit";"Traversenweg";"Kraft";"Zugdehnung (Traversenweg)";"Zugspannung"',
                '"(s)";"(mm)";"(N)";"(%)";"(MPa)"',
                *[f'"{k},0";"{comma(x)}";"{comma(f)}";"{comma(e)}";"{comma(s)}"' for k, x, f, e, s in ROWS],
            ]
        ).encode("utf-16"),
        "bluehill_italian": joined(
            [
                "Nome del metodo;Trazione tessuto",
                f"Larghezza;{WIDTH},00;mm",
                f"Spessore;{comma(THICKNESS)}0;mm",
                f"Lunghezza utile;{LENGTH},0;mm",
                "",
                "Tempo (s);Estensione a trazione (mm);Carico (N)",
                *[f"{k};{comma(x)};{comma(f)}" for k, x, f, *_ in ROWS],
            ]
        ).encode("cp1252"),
        "bluehill_portuguese": joined(
            ["Tempo (s);Extensão de tração (mm);Carga (N)"]
            + [f"{k};{comma(x)};{comma(f)}" for k, x, f, *_ in ROWS]
            + ["Média;27,5;14,2", "Desvio padrão;15,1;12,0"]
        ).encode("latin-1"),
        "bluehill_spanish": joined(
            ["Tiempo (s);Extensión por tracción (mm);Carga (N)"]
            + [f"{k};{comma(x)};{comma(f)}" for k, x, f, *_ in ROWS]
        ).encode("latin-1"),
        "testxpert3_workbook": workbook(
            {
                "Parameter": [
                    ["Prüfer", "M"],
                    ["Probenbreite", ("50",), "mm"],
                    ["Probendicke", ("0.5",), "mm"],
                ],
                "Ergebnisse": [["", "Fmax", "eB"], [None, "N", "%"], ["Probe 1", ("37.5",), ("50",)]],
                "Statistik": [["Serie", "Fmax"], ["n = 1", "N"], ["x̅", ("37.5",)], ["s", ("0",)]],
                "Probe 1": [*values, *[[(str(k),), (e,), (f,)] for k, _, f, e, _ in ROWS]],
            }
        ),
        "testxpert3_english": joined(
            ['"Test time";"Standard travel";"Standard force"', '"s";"mm";"N"']
            + [f"{k};{x};{f}" for k, x, f, *_ in ROWS]
        ).encode(),
        "tw_elite": joined(
            [
                '"Test Run Name","Tension 1"',
                f'"Width","{WIDTH}.000","mm"',
                f'"Thickness","{THICKNESS}00","mm"',
                f'"Gage Length","{LENGTH}.000","mm"',
                '""',
                '"Crosshead","Load","Time","Extensometer"',
                '"mm","N","s","mm"',
                *[f'"{x}","{f}","{k}","0"' for k, x, f, *_ in ROWS],
            ]
        ).encode(),
        "trapezium_x": joined(
            [
                '"Test Name:","Tensile"',
                '"Parameter","Thickness","Width","Gauge_Length"',
                '"Unit","mm","mm","mm"',
                f'"1 _ 1","{THICKNESS}","{WIDTH}","{LENGTH}"',
                "",
                '"1 _ 1"',
                '"Time","Force","Stroke","Stress","Strain"',
                '"sec","N","mm","N/mm2","%"',
                *[f'"{k}","{f}","{x}","{s}","{e}"' for k, x, f, e, s in ROWS],
            ]
        ).encode(),
        "trapezium_german": joined(
            ['"Zeit","Kraft","Hub"', '"sek","N","mm"', *[f"{k},{f},{x}" for k, x, f, *_ in ROWS]]
        ).encode(),
        "nexygen": joined(
            [
                "NEXYGENPlus",
                "Batch Reference,Fabric 1",
                f"Width (mm),{WIDTH}",
                f"Gauge Length (mm),{LENGTH}",
                "",
                "Load (N),Extension from Preload (mm),Time (s)",
                *[f"{f},{x},{k}" for k, x, f, *_ in ROWS],
            ]
        ).encode(),
        "hounsfield": joined(["QMAT 5.3", "Ext (mm)\tForce (N)", *[f"{x}\t{f}" for _, x, f, *_ in ROWS]]).encode(),
        "galdabini": joined(
            ["LABTEST;;", "Provino n.;1;", "Tempo [s];Allungamento [mm];Forza [daN]"]
            + [f"{k};{comma(x)};{comma(shifted(f, -1))}" for k, x, f, *_ in ROWS]
        ).encode("latin-1"),
        "trios": joined(
            ["Filename\tx.tri", "Instrument name\tARES-G2", "", "[step]", "Axial tension - 1"]
            + ["Step time\tGap\tAxial force", "s\tmm\tN"]
            + [f"{k}\t{100 + Decimal(x)}\t-{f}" for k, x, f, *_ in ROWS]
        ).encode(),
        "aramis": joined(
            ["#GOM ASCII file", "Stage;Time [s];Technical strain Y [%];Analog input: Force [kN]"]
            + [f"{k};{k};{comma(e)};{comma(shifted(f, -3))}" for k, _, f, e, _ in ROWS]
        ).encode(),
        "aramis_major": joined(
            ["Stage;Strain major technical [%];AI: Force [N]", *[f"{k};{e};{f}" for k, _, f, e, _ in ROWS]]
        ).encode(),
        "vic_extensometer": joined(
            ['"Filename","Time_1","Dev1/ai0: Load [N]","E0 Strain [mm/mm]"']
            + [f'"a_{k:04d}.tif","{k}","{f}","{shifted(e, -2)}"' for k, _, f, e, _ in ROWS]
        ).encode(),
        "vic_engineering": joined(
            ['"Index","exx [1] - engr.","Force [N]"'] + [f"{k},{shifted(e, -2)},{f}" for k, _, f, e, _ in ROWS]
        ).encode(),
        "catman": joined(
            ["Catman Version 5", "T0 = 22.11.2026", "Zeit  1 - Standardmessrate [s]\tKraft [N]\tWeg [mm]"]
            + [f"{k}\t{comma(f)}\t{comma(x)}" for k, x, f, *_ in ROWS]
        ).encode("cp1252"),
        "french_stand": joined(
            [
                "Éprouvette : 1",
                f"Longueur de référence : {LENGTH} mm",
                "",
                "Temps\tDéplacement traverse\tCharge",
                "s\tmm\tN",
                *[f"{k}\t{comma(x)}\t{comma(f)}" for k, x, f, *_ in ROWS],
            ]
        ).encode("utf-16-le"),
        "strip_of_50_mm": joined(
            ["Dehnung [%];Kraft [N/50 mm]", *[f"{comma(e)};{comma(times(s, 25))}" for *_, e, s in ROWS]]
        ).encode(),
        "thousands_point": joined(
            ["Weg [µm];Kraft [mN]"] + [f"{comma(times(x, 1000))};{grouped(f, '.', ',')}" for _, x, f, *_ in ROWS]
        ).encode("cp1252"),
        "fortran": joined(
            ["  STRAIN        STRESS_MPa", *[f"  {fortran(e)}  {fortran(s)}" for e, s in PULL]], "\n"
        ).encode(),
        "fortran_commas": joined(
            ["strain,stress [MPa]", *[f"{fortran(e)},{fortran(s)}" for e, s in PULL]], "\n"
        ).encode(),
        "means_between_specimens": joined(
            ["Probe;Dehnung [%];Spannung [MPa]"]
            + [f"1;{comma(e)};{comma(s)}" for *_, e, s in ROWS]
            + ["Mittelwert;27,5;0,57"]
            + [f"2;{comma(e)};{comma(s)}" for *_, e, s in ROWS]
            + ["Mittelwert;27,5;0,57", "Standardabweichung;0;0"]
        ).encode("cp1252"),
        "dates_with_halves_of_the_day": joined(
            ["Date,Time,Strain (%),Stress (MPa)"] + [f"11/22/2026,10:00:{k:02d} PM,{e},{s}" for k, _, _, e, s in ROWS]
        ).encode(),
    }


def labs_to_settle() -> dict[str, bytes]:
    """Files that are refused with the option that settles them."""
    return {
        "statimat_by_fineness": joined(
            ["Feinheit: 20 tex", "Nr.;Dehnung [%];Feinheitsfestigkeit [N/tex]"]
            + [f"{k};{comma(e)};{comma(f)}" for k, _, f, e, _ in ROWS]
        ).encode(),
        "two_virtual_extensometers": joined(
            ["Frame,E0 Strain [%],E1 Strain [%],Load [N]"]
            + [f"{k},{e},-{Decimal(e) / 10},{f}" for k, _, f, e, _ in ROWS]
        ).encode(),
    }
