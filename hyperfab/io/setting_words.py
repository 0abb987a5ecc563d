"""What testing machines and offices call what they state above a table: words as those of columns."""

from __future__ import annotations

from hyperfab.io.heading_words import COLUMNS

#: Settings that stand above a table.
SETTINGS: dict[str, str] = {
    "width": """width; specimen width; sample width; strip width; arm width; initial width; breite; probenbreite;
        streifenbreite; anfangsbreite; probenbreite b0; b0; w0; b; w; ancho; anchura; ancho de la probeta;
        ancho de probeta; ancho inicial; largeur; largeur de l eprouvette; largeur eprouvette; largeur initiale;
        larghezza; larghezza provino; larghezza del provino; larghezza iniziale; largura;
        largura do corpo de prova; largura inicial; 幅; 宽度; ширина; genislik; numune genisligi; 试样宽度;
        样品宽度; 試験片幅; breedte; proefstukbreedte; szerokosc; szerokosc probki; leveys; naytteen leveys; sirka;
        sirka vzorku; sirka ramene; bredd; provbredd; 폭; 너비; 시편 폭; 시편폭""",
    "thickness": """thickness; specimen thickness; sample thickness; initial thickness; fabric thickness; dicke;
        probendicke; anfangsdicke; warendicke; stoffdicke; probendicke a0; a0; h0; espesor;
        espesor de la probeta; espesor de probeta; espesor inicial; epaisseur; epaisseur de l eprouvette;
        epaisseur eprouvette; epaisseur initiale; spessore; spessore provino; spessore del provino;
        spessore iniziale; espessura; espessura do corpo de prova; espessura inicial; 厚さ; 厚み; 厚度; толщина;
        kalinlik; numune kalinligi; 试样厚度; 样品厚度; 試験片厚さ; dikte; proefstukdikte; grubosc;
        grubosc probki; paksuus; naytteen paksuus; tloustka; tloustka vzorku; tjocklek; 두께; 시편 두께; 시편두께""",
    "gauge length": """gauge length; gage length; gauge; gage; nominal gage length; sample gauge length;
        gauge length standard travel; gage length standard travel; messlange standardweg; l0 standardweg;
        l0 course standard; longueur de mesure course standard; initial gauge length; initial specimen length;
        initial length; original length; original gauge length; nominal gauge length;
        tensile strain gauge length; compressive strain gauge length; specimen gauge length; l0; lo; l 0;
        free length; messlange; anfangsmesslange; anfangslange; bezugslange; ausgangslange;
        longitud de referencia; longitud inicial; longitud calibrada; longitud util; base de medida;
        longitud de medida; longueur initiale; longueur de reference; longueur utile; longueur de mesure;
        base de mesure; lunghezza iniziale; lunghezza utile; lunghezza di riferimento; tratto utile;
        base di misura; comprimento inicial; comprimento util; comprimento de referencia; comprimento de medida;
        標点距離; ゲージ長さ; 标距; база; начальная длина; olcu boyu; olcu uzunlugu; ilk boy; ilk uzunluk;
        原始标距; 初始标距; 初始长度; 標線間距離; 標線距離; bench mark distance; benchmark distance;
        distance between bench marks; distance between marks; markenabstand; messmarkenabstand;
        abstand der messmarken; longueur entre reperes; longueur initiale entre reperes; distance entre reperes;
        distancia entre marcas; longitud entre marcas; longitud inicial entre marcas; distanza tra i riferimenti;
        distanza tra le marche; lunghezza iniziale tra i riferimenti; distancia entre marcas de referencia;
        meetlengte; beginlengte; dlugosc pomiarowa; dlugosc poczatkowa; baza pomiarowa; mittapituus; merena delka;
        pocatecni delka; pocatecni merena delka; matlangd; 표점거리; 표점 거리; 표점간 거리""",
    "extensometer length": """extensometer gauge length; extensometer gage length; extensometer length; gauge length
        extensometer; gage length extensometer; strain 1 gauge length; strain 2 gauge length; messlange extensometer;
        longitud de referencia extensometro; longueur de reference extensometre""",
    "gauge": """extensometer; extensometer type; strain source; strain read by; strain measured by; strain measurement;
        strain measurement method; tensile strain source; axial strain source; dehnungsaufnehmer; dehnungsmessung;
        langenanderungsaufnehmer; extensometro; extensometre; estensometro; medida de la deformacion;
        mesure de la deformation; misura della deformazione""",
    "grip distance": """grip distance; test length; jaw span; distance between jaws; distance between clamps;
        distance between grips; initial distance between grips; initial distance between jaws;
        initial jaw separation; length between grips; length between jaws; clamp separation;
        free clamping length; nip distance; pruflange; longueur d epreuve; distanza iniziale tra i morsetti;
        distanza iniziale tra le pinze; grip separation; grip to grip separation;
        grip to grip separation at the start position; jaw separation; jaw distance; clamp distance;
        clamping length; clamping distance; initial grip separation; einspannlange; klemmlange;
        freie einspannlange; einspannlange bei startposition; einspannlange le; le; spannlange;
        distancia entre mordazas; separacion de mordazas; separacion entre mordazas; longitud entre mordazas;
        distance entre mors; ecartement des mors; longueur entre mors; longueur de serrage;
        distanza tra i morsetti; distanza morsetti; distanza tra le pinze; distancia entre garras;
        distancia entre as garras; つかみ間隔; チャック間距離; 夹距; ceneler arasi mesafe; cene mesafesi;
        夹持距离; 夹具间距; 夹持长度; 隔距; inspanlengte; klemafstand; klemlengte; dlugosc mocowania;
        rozstaw szczek; odleglosc miedzy szczekami; leukavali; kiinnityspituus; upinaci delka; vzdalenost celisti;
        inspanningslangd; 그립간 거리; 그립 간격; 물림 거리""",
    "specimen length": """specimen length; sample length; length; overall length; total length; probenlange;
        lange; gesamtlange; longitud; longitud de la probeta; longitud total; longueur; longueur de l eprouvette;
        longueur eprouvette; longueur totale; lunghezza; lunghezza del provino; lunghezza provino;
        lunghezza totale; comprimento; comprimento do corpo de prova; comprimento total; proefstuklengte;
        dlugosc probki; dlugosc calkowita""",
    "height": """height; specimen height; sample height; initial height; hohe; probenhohe; anfangshohe; altura;
        altura de la probeta; hauteur; hauteur de l eprouvette; altezza; altezza del provino""",
    "diameter": """diameter; specimen diameter; d0; durchmesser; probendurchmesser; diametro;
        diametro de la probeta; diametre; diametre de l eprouvette; 直径; диаметр; srednica; halkaisija; prumer;
        직경""",
    "area": """area; specimen area; sample area; cross section; specimen cross section;
        specimen cross sectional area; sample cross section; cross sectional area; cross section area;
        initial area; s0; querschnitt; querschnittsflache; anfangsquerschnitt; probenquerschnitt; seccion;
        area de la seccion; area inicial; seccion transversal; section; section initiale; aire; sezione;
        area iniziale; secao; secao transversal; 断面積; площадь; doorsnede; przekroj; pole przekroju;
        pole przekroju poprzecznego; poikkipinta ala; prurez; tvarsnitt; 단면적""",
    "rate": COLUMNS["rate"],
    "temperature": COLUMNS["temperature"] + "; " + COLUMNS["chamber"],
    "direction": COLUMNS["direction"],
    "specimen": COLUMNS["specimen"],
    "cycle": "cycle; zyklus; ciclo",
    "branch": "branch",
    "stress sd": "stress sd",
    "test": """test; test kind; test type; test method; method; test name; type of test; kind of test; prufung; prufart;
        prufverfahren; prufvorschrift; prufnorm; versuch; versuchsart; ensayo; tipo de ensayo; metodo; metodo de
        ensayo; essai; type d essai; methode; methode d essai; prova; tipo di prova; metodo di prova; ensaio;
        tipo de ensaio; metodo de ensaio; standard; norm; norma; norme;
        deney; test adi; 试验名称; 试验类型; 试验方法; 試験種類; 試験名; 시험명; 시험 방법; nazev zkousky""",
}
#: Settings that are known and change nothing: not worth a word.
QUIET = """source; license; licence; material; fabric; operator; prufer; bearbeiter; tester; customer; kunde;
        company; firma; date; datum; fecha; data; time; comment; comments; remark; note; title; name; file;
        filename; machine; software; version; author; lot; batch; project; report; description; laboratory; lab"""
