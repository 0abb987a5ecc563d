"""A fourth round of exports: channels with properties of their own, sizes among the channels, specimens side by side.

Instron Bluehill with the digital position, ZwickRoell TRA, MTS TestWorks and 793, Shimadzu Trapezium in pairs, Mark-10
MESURgauge, TA RSA-G2, Anton Paar RheoCompass, GOM and Aramis, Testometric winTest, Lloyd NEXYGEN, EMIC Tesc, DEWESoft.
"""

from __future__ import annotations

from decimal import Decimal

from lab_exports import ROWS
from machine_exports import LENGTH, THICKNESS, WIDTH, comma, joined, shifted, times, workbook

TIMED = [(k, x, f) for k, x, f, *_ in ROWS]


def stands() -> dict[str, bytes]:
    """Files that are read as they are."""
    return {
        "bluehill_beside_quoted": joined(
            [
                '"Results Table 2";"";"";"";"";""',
                '"Specimen 1";"";"";"Specimen 2";"";""',
                '"Time";"Extension";"Load";"Time";"Extension";"Load"',
                '"(s)";"(mm)";"(N)";"(s)";"(mm)";"(N)"',
                *[f'"{k}";"{x}";"{f}";"{k}";"{x}";"{f}"' for k, x, f in TIMED],
            ]
        ).encode(),
        "bluehill_digital_position": joined(
            [
                '"Time (sec)","Extension (Digital Position) (mm)","Load(Load Cell) (N)",'
                '"Total Cycle Count(Digital Position Waveform) "',
                *[f'"{k}","{x}","{f}","1"' for k, x, f in TIMED],
            ]
        ).encode(),
        "testxpert_tra": joined(
            [
                '"Probe 1"',
                '"Vorkraft";0,5;"N"',
                '"Prüfgeschwindigkeit";100;"mm/min"',
                f'"Probenbreite b0";{WIDTH};"mm"',
                f'"Probendicke a0";{comma(THICKNESS)};"mm"',
                f'"Einspannlänge bei Startposition";{LENGTH};"mm"',
                "",
                '"Prüfzeit";"Traversenweg absolut";"Dehnung";"Standardkraft"',
                '"s";"mm";"%";"N"',
                *[f"{k},00;{comma(str(100 + Decimal(x)))};{comma(e)};{comma(f)}" for k, x, f, e, _ in ROWS],
            ]
        ).encode("cp1252"),
        "testworks_two_runs": joined(
            [
                line
                for run in (1, 2)
                for line in (
                    f"Specimen,{run}",
                    "Specimen Width,50.0,mm",
                    "Grip Separation,100.0,mm",
                    "Axial Displacement,Axial Force,Time",
                    "mm,N,sec",
                    *[f"{x},{f},{k}" for k, x, f in TIMED],
                    "",
                )
            ]
        ).encode(),
        "mts_segments": joined(
            ["Data Header:\tTime: 10 Sec\t11/22/2026 10:00:00 AM", "Station Name:\tx"]
            + ["Axial Displacement\tAxial Force\tAxial Segment Count\tRunning Time", "mm\tkN\tsegments\tSec"]
            + [f"{x}\t{shifted(f, -3)}\t2\t{k}" for k, x, f in TIMED]
        ).encode(),
        "trapezium_pairs": joined(
            ['"1 _ 1","","","1 _ 2","",""', '"Time","Force","Stroke","Time","Force","Stroke"']
            + ['"sec","N","mm","sec","N","mm"']
            + [f'"{k}","{f}","{x}","{k}","{f}","{x}"' for k, x, f in TIMED]
        ).encode(),
        "trapezium_chinese": joined(
            ['"时间","试验力","位移"', '"sec","N","mm"', *[f'"{k}","{f}","{x}"' for k, x, f in TIMED]]
        ).encode("gb18030"),
        "mesurgauge": joined(
            ["MESUR gauge Plus", "Reading\tLoad [N]\tTravel [mm]\tTime [sec.]"]
            + [f"{k + 1}\t{f}\t{x}\t{k}" for k, x, f in TIMED]
            + ["", "Maximum\t37.5\t50", "Minimum\t1.5625\t5", "Average\t14.1\t27.5"]
        ).encode(),
        "rsa": joined(
            ["Variables", "Step time,Displacement,Axial force,Temperature", "s,µm,N,°C"]
            + [f"{k},{times(x, 1000)},{f},23.0" for k, x, f in TIMED]
        ).encode("utf-8-sig"),
        "rheocompass_german": joined(
            ["Projekt:\tStrick", "Abschnitt und Daten:\t1\t10", "Daten:\tPkt-Nr.\tZeit\tSpalt\tNormalkraft"]
            + ["\t\t\t\t", "\t\t[s]\t[mm]\t[N]"]
            + [f"\t{k}\t{k}\t{comma(str(100 + Decimal(x)))}\t-{comma(f)}" for k, x, f in TIMED]
        ).encode("utf-16"),
        "gom_extensometer": joined(
            ["Time [s];Extensometer 1.ΔL [mm];Extensometer 1.L0 [mm];Force [N]"]
            + [f"{k};{comma(x)};100,0;{comma(f)}" for k, x, f in TIMED]
        ).encode(),
        "vic_lengths": joined(
            ['"Index","E0: L0 [mm]","E0: dL [mm]","Dev1/ai1: Load [kN]"']
            + [f'"{k}","100","{x}","{shifted(f, -3)}"' for k, x, f in TIMED]
        ).encode(),
        "channels_with_properties": joined(
            ["Channel;Time;Displacement;Force", "Unit;s;mm;N", "Sensor;-;LVDT 3;U9C"]
            + ["Calibration;1;0,5;2,0", "Min;0;5;1,5625", "Max;9;50;37,5"]
            + [f";{k};{comma(x)};{comma(f)}" for k, x, f in TIMED]
        ).encode(),
        "length_by_its_letter": joined(
            ["L [mm];F [N];L0 [mm]"] + [f"{comma(str(100 + Decimal(x)))};{comma(f)};100,0" for _, x, f in TIMED]
        ).encode(),
        "spanish_workbook": workbook(
            {
                "Resumen": [["Ensayo", "Carga máxima (N)"], [("1",), ("37.5",)]],
                "Datos": [
                    ["Ancho", ("50",), "mm"],
                    ["Longitud inicial", ("100",), "mm"],
                    [],
                    ["Tiempo", "Desplazamiento", "Carga"],
                    ["s", "mm", "N"],
                    *[[(str(k),), (x,), (f,)] for k, x, f in TIMED],
                ],
            }
        ),
        "spanish_utf16_be": (
            "\ufeff"
            + joined(
                ["Muestra;1", "Tiempo (s);Desplazamiento (mm);Fuerza (kN)"]
                + [f"{k};{comma(x)};{comma(shifted(f, -3))}" for k, x, f in TIMED]
            )
        ).encode("utf-16-be"),
    }


def stands_to_settle() -> dict[str, bytes]:
    """Files that are refused with the option that settles them."""
    return {
        "wintest": joined(
            ["winTest Analysis", "Test No.,1", "Def. (mm),Force (N),Time (s)"] + [f"{x},{f},{k}" for k, x, f in TIMED]
        ).encode(),
        "nexygen_french": joined(
            ["NEXYGENPlus", "Charge (N);Extension depuis précharge (mm);Temps (s)"]
            + [f"{comma(f)};{comma(x)};{k}" for k, x, f in TIMED]
        ).encode("latin-1"),
        "emic": joined(
            ["Programa: Tesc versão 3.04", "Tempo (s)\tDeformação (mm)\tForça (N)\tForça (kgf)"]
            + [f"{k}\t{comma(x)}\t{comma(f)}\t{comma(f'{float(f) / 9.80665:.5f}')}" for k, x, f in TIMED]
        ).encode("latin-1"),
        "dewesoft": joined(
            ["Data1", "", "Time (s)\tForce/AI 1 (N)\tDisp/AI 2 (mm)"] + [f"{k}\t{f}\t{x}" for k, x, f in TIMED]
        ).encode(),
        "strain_and_its_correction": joined(
            ["Time (s),Corrected Strain (%),Strain (%),Stress (MPa)"]
            + [f"{k},{e},{float(e) + 1:.2f},{s}" for k, _, _, e, s in ROWS]
        ).encode(),
        "force_and_tared_force": joined(
            ["Weg (mm);Kraft tariert (N);Kraft (N)"] + [f"{x};{f};{float(f) + 0.5}" for _, x, f in TIMED]
        ).encode(),
        "units_alone": joined(["s;mm;N", *[f"{k};{comma(x)};{comma(f)}" for k, x, f in TIMED]]).encode(),
        "aramis_length": joined(
            ["Stage;Extensometer L [mm];Extensometer L0 [mm];Force [N]"]
            + [f"{k};{100 + Decimal(x)};100;{f}" for k, x, f in TIMED]
        ).encode(),
        "estonian_workbook": workbook(
            {"Taul1": [["Pikenemine (%)", "Pinge (MPa)"], *[[(e,), (s,)] for *_, e, s in ROWS]]}
        ),
    }
