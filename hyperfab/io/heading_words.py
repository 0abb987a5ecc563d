"""What testing machines and offices call their columns and tests, in sixteen languages.

Words stand as ``hyperfab.io.dictionary.plain`` leaves them: lower case, without accents, punctuation as spaces.
Sources: the export headings of Instron Bluehill, ZwickRoell testXpert, MTS TestWorks and TestSuite, Shimadzu Trapezium,
Mark-10, Textechno, TA and Anton Paar rheometers, GOM, VIC and Istra, as their manuals and users' files show them.
"""

from __future__ import annotations

#: Words of a column by what it holds. A unit decides where words have two senses.
COLUMNS: dict[str, str] = {
    "stretch": """stretch; stretch ratio; extension ratio; elongation ratio; draw ratio; principal stretch; nominal
        stretch; lambda; lam; l l0; l/l0; streckung; streckverhaltnis; dehnungsverhaltnis; verstreckgrad; f11;
        alargamiento relativo lambda; taux d elongation; rapporto di estensione; axial stretch""",
    "strain": """strain; engineering strain; nominal strain; technical strain; eng strain; tensile strain;
        axial strain; longitudinal strain; strain reading; elong; epsilon; eps; e; major strain; dehnung;
        standarddehnung; nenndehnung; feindehnung; verformung; technische dehnung; nominelle dehnung; zugdehnung;
        axialdehnung; langsdehnung; langsdehnung technisch; deformacion; deformacion unitaria;
        deformacion por traccion; deformacion de traccion; deformacion nominal; deformacion ingenieril; deform;
        deformation; deformation nominale; deformation axiale; deformation en traction;
        deformation longitudinale; deformation rationnelle; deformazione; deformazione a trazione;
        deformazione nominale; deformazione ingegneristica; deformacao; deformacao de tracao; deformacao nominal;
        deformacao de engenharia; deformacao axial; elongation; tensile elongation; elongacion; elongacao;
        alargamiento; allongement; allungamento; alongamento; gl dehnung; distancia recorrida relativa; ひずみ;
        歪み; 歪; 伸び率; 应变; 伸长率; 拉伸应变; 工程应变; 引張ひずみ; 引張りひずみ; 公称ひずみ; ave; ave 1;
        ave 2; ave1; ave2; деформация; относительная деформация; относительное удлинение; birim sekil degistirme;
        birim uzama; gerinim; sekil degistirme; 拉伸率; 断裂伸长率; rek; technische rek; vervorming;
        odksztalcenie; odksztalcenie nominalne; odksztalcenie inzynierskie; wydluzenie wzgledne; venyma; suhteellinen
        venyma; deformace; pomerne prodlouzeni; pomerna deformace; tojning; 변형률; 신율; 연신율; 신도""",
    "extension": """extension; s; displacement; ext; disp; tensile extension; tensile displacement;
        axial displacement; axial extension; crosshead displacement; crosshead extension; crosshead travel;
        crosshead; stroke; travel; actuator displacement; grip displacement; machine extension;
        extension from preload; preload extension; distance; weg; standardweg; verlangerung;
        standardverlangerung; langenanderung; traversenweg; kolbenweg; hub; prufweg; maschinenweg; dehnweg;
        wegaufnehmer; extensometer; video extensometer; delta l; dl; delta length; u; ux; uy; desplazamiento;
        desplazamiento de la cruceta; desplazamiento cruceta; desplazamiento del travesano; recorrido; carrera;
        deplacement; deplacement de la traverse; deplacement traverse; deplacement de traverse;
        deplacement du mors; course; course standard; course traverse; spostamento; spostamento traversa;
        spostamento della traversa; corsa; estensione; deslocamento; deslocamento do travessao;
        deslocamento travessao; deslocamento da travessa; curso; extensao; 変位; ストローク; 伸び; 位移; 变形;
        伸长; 拉伸位移; 横梁位移; ave; ave 1; ave 2; ave1; ave2; перемещение; удлинение; ход; uzama; deplasman;
        yer degistirme; allong; 伸长量; 延伸; verlenging; verplaatsing; traverseweg; wydluzenie; przemieszczenie;
        przemieszczenie trawersy; droga; przyrost dlugosci; siirtyma; pidentyma; prodlouzeni; posuv; posunuti;
        forlangning; 변위; 신장; 연신; 스트로크""",
    "position": """position; crosshead position; crosshead absolute; traverse absolue;
        traverse; traverse absolut; traversenweg absolut; traversenposition;
        standardtraversenweg; axial position; actuator position; posicion; posicion de la cruceta; position
        traverse; posizione; posizione traversa; posicao""",
    "length": """gap; length; current length; lange; aktuelle lange; longitud; longueur; lunghezza; comprimento;
        spalt; measuring gap; specimen length; grip distance; entrefer; l; size; lengte; dlugosc""",
    "force": """force; load; f; shear force; scherkraft; schubkraft; fuerza de corte; force de cisaillement;
        forza di taglio; tensile force; tensile load; standard force; static force; test force; axial force;
        axial load; load cell; fz; load reading; force reading; pull force; maximum pull; kraft; standardkraft;
        prufkraft; zugkraft; last; axialkraft; fuerza; fuerza de traccion; carga; carga de traccion; effort;
        force de traction; force standard; charge; forza; forza di trazione; forza standard; carico;
        carico di trazione; forca; forca de tracao; forca padrao; carga de tracao; 試験力; 荷重; 力; 试验力;
        载荷; 负荷; 拉力; 拉伸载荷; 引張荷重; нагрузка; усилие; сила; kuvvet; cekme kuvveti; yuk; 拉伸力; kracht;
        trekkracht; belasting; sila; sila rozciagajaca; obciazenie; voima; kuorma; zatizeni; tahova sila; 하중; 힘;
        시험력; 인장하중""",
    "stress": """stress; nominal stress; engineering stress; tensile stress; eng stress; technical stress;
        axial stress; sigma; s; p; pk1; first piola kirchhoff stress; piola stress; nominal stress p; spannung;
        nennspannung; zugspannung; technische spannung; standardspannung; nominelle spannung; esfuerzo;
        esfuerzo de traccion; esfuerzo nominal; esfuerzo por traccion; esfuerzo ingenieril; tension;
        tension nominal; tension de traccion; contrainte; contrainte nominale; contrainte de traction;
        contrainte en traction; contrainte axiale; sforzo; sforzo nominale; sforzo di trazione; tensione;
        tensione nominale; sollecitazione; tensao; tensao nominal; tensao de tracao; tensao de engenharia; 応力;
        应力; 拉伸应力; 工程应力; 引張応力; 公称応力; напряжение; gl spannung; gerilme; cekme gerilmesi;
        muhendislik gerilmesi; spanning; trekspanning; technische spanning; naprezenie; naprezenie rozciagajace;
        naprezenie nominalne; jannitys; vetojannitys; napeti; tahove napeti; dragspanning; 응력; 인장응력""",
    "true stress": """true stress; cauchy stress; cauchy; true tensile stress; wahre spannung; cauchy spannung; esfuerzo
        verdadero; esfuerzo real; esfuerzo de cauchy; contrainte vraie; contrainte de cauchy; sforzo vero; tensione
        vera; tensione reale; tensao verdadeira; tensao real; sigma true; true sigma; 真应力; 真实应力; 真応力""",
    "true strain": """true strain; epsilon t; epsilont; eps t; epst;
        log strain; logarithmic strain; hencky strain; hencky; wahre dehnung;
        logarithmische dehnung; umformgrad; deformacion verdadera; deformacion logaritmica; deformacion real;
        deformation vraie; deformation logarithmique; deformazione vera; deformazione logaritmica; deformacao
        verdadeira; deformacao logaritmica; 真应变; 真实应变; 对数应变; 真ひずみ""",
    "green strain": """green strain; lagrange strain; lagrangian strain; green lagrange strain; green lagrange""",
    "membrane stress": """membrane stress; force per width; load per width; force width; load width;
        force per unit width; line load;
        linienkraft;
        breitenbezogene kraft; kraft pro breite; fuerza por ancho; fuerza por unidad de ancho; force par largeur;
        effort lineique; forza per larghezza; forca por largura; unit load""",
    "volume ratio": "volume ratio; volumenverhaltnis; relative volume; j",
    "shear strain": """shear strain; shear angle; scherwinkel; schubwinkel; angulo de corte; angulo de cizalla;
        angle de cisaillement; angolo di taglio; angulo de cisalhamento; gamma; scherung; schubverzerrung; scherdehnung;
        shear deformation; deformacion angular;
        deformacion de corte; cisaillement; deformation de cisaillement; deformazione a taglio; scorrimento;
        deformacao de cisalhamento""",
    "shear stress": """shear stress; tau; schubspannung; scherspannung; esfuerzo cortante; esfuerzo de corte;
        contrainte de
        cisaillement; sforzo di taglio; tensione di taglio; tensao de cisalhamento; tensao cisalhante""",
    "stress sd": """stress sd; stress std; sd stress; std stress; stress stdev; standard deviation of stress; spannung
        sd; membrane stress sd""",
    "time": """time; t; elapsed; elapsed time; relative time; rel time; test time; total time; running time; run time;
        time stamp; timestamp; step time; zeit; prufzeit; testzeit; versuchszeit; laufzeit; messzeit; tiempo;
        tiempo de ensayo; tiempo transcurrido; temps; temps d essai; temps ecoule; tempo; tempo di prova;
        tempo trascorso; tempo de ensaio; tempo decorrido; 時間; 経過時間; 时间; 試験時間; время; sure; zaman;
        gecen sure; tijd; testtijd; czas; czas badania; aika; cas; tid; 시간""",
    "temperature": """temperature; temp; test temperature; specimen temperature; sample temperature; temperatur;
        pruftemperatur; probentemperatur; temperatura; temperatura de ensayo; temperatura de la probeta;
        temperature d essai; temperatura di prova; temperatura de ensaio; t sample; 温度; 試験温度; 试验温度;
        测试温度; температура; t c; sicaklik; numune sicakligi; temperatuur; proeftemperatuur;
        temperatura badania; temperatura probki; lampotila; teplota; 온도; 시험온도""",
    "chamber": """chamber temperature; oven temperature; chamber temp; ambient temperature; room temperature;
        kammertemperatur; raumtemperatur; umgebungstemperatur; temperatura ambiente; temperatura de la camara;
        temperature ambiante; temperature enceinte; temperatura ambiente interna; temperatura da camara; t
        chamber""",
    "rate": """rate; strain rate; vel; velocity; speed; test speed; testing speed; crosshead speed; stretch rate;
        pull speed; rate 1; dehnrate; dehngeschwindigkeit; prufgeschwindigkeit; geschwindigkeit;
        abzugsgeschwindigkeit; velocidad; velocidad de ensayo; velocidad de deformacion; vitesse;
        vitesse d essai; vitesse de deformation; velocita; velocita di prova; velocita di deformazione;
        velocidade; velocidade de ensaio; taxa de deformacao; скорость; snelheid; proefsnelheid; reksnelheid;
        predkosc; predkosc badania; nopeus; rychlost; hastighet; 속도; 시험속도""",
    "cycle": """cycle; cycles; cycle no; cycle nr; cycle number; cycle count; cyclecount; total cycles;
        cycle index; zyklus; zyklen; zyklusnummer; zyklus nr; zykluszahler; zyklenzahler; hysteresenummer; ciclo;
        ciclos; numero de ciclo; ciclo n; n ciclo; nombre de cycles; numero de cycle; cicli; numero ciclo;
        numero do ciclo; サイクル; サイクル数; 循环; 循环数; 循环次数; 循环计数; 周期; цикл; cevrim; dongu;
        cyclus; cykl; nr cyklu; sykli; cyklus; 사이클""",
    "branch": """branch; loading direction; load branch; ast; be entlastung; belastungsast; rama; branche;
        ramo; hin ruck""",
    "direction": """direction; fabric direction; specimen direction; sample direction; test direction;
        material direction; orientation; cut direction; richtung; probenrichtung; prufrichtung; materialrichtung;
        entnahmerichtung; direccion; direccion del tejido; sens; sens du tissu; orientacion; direzione;
        direzione del tessuto; direcao; direcao do tecido; yon; numune yonu; 方向; 试样方向; richting;
        proefrichting; kierunek; kierunek badania; suunta; smer; riktning; 방향""",
    "specimen": """specimen; sample; specimen no; specimen nr; specimen number; specimen id; specimen name;
        specimen label; sample no; sample id; sample name; sample number; test piece; replicate; test no;
        test number; specimen identifier; probe; probe nr; proben nr; probennummer; proben id; probenbezeichnung;
        probekorper; prufling; prufkorper; probeta; probeta n; probeta no; numero de probeta; muestra; muestra n;
        identificacion de la probeta; eprouvette; eprouvette n; numero d eprouvette; echantillon; provino;
        provino n; numero provino; campione; corpo de prova; corpo de prova n; amostra; cp; numune; numune no;
        试样; 试样编号; 試験片; proefstuk; monster; probka; nr probki; numer probki; nayte; vzorek; cislo vzorku; prov;
        시편; 시료; 시편 번호""",
    "test": "test; test kind; test mode; deformation mode; mode",
}
#: Titles that are a unit and say by it that they are the time; LabVIEW's ``X_Value`` counts seconds.
TIMES: dict[str, str] = {
    "s": "seconds; secs; unix time; unix timestamp; epoch time; sekunden; segundos; secondes; secondi; saniye; x value",
    "min": "minutes; mins; minuten; minutos; minuti; dakika",
    "ms": "milliseconds; millisekunden; milisegundos; millisecondes; millisecondi",
    "h": "hours; hrs; stunden; horas; heures; saat",
}
#: Units in words, as offices write them.
UNITS: dict[str, str] = {
    "N": "newton; newtons; nt; н", "kN": "kilonewton; kn; кн",
    "s": """sec; secs; second; seconds; sek; sekunden; sekunde; seg; segundos; segundo; secondes; seconde; secondi;
        с; сек""", "min": "minute; minutes; minuten; minutos; minuti; мин",
    "mm": "millimeter; millimeters; millimetre; millimetres; milimetros; millimetri; мм",
    "MPa": "megapascal; mpa; мпа", "kPa": "kilopascal; kpa; кпа", "cN": "cn", "mN": "mn", "Pa": "pa; па",
    "GPa": "gpa; гпа",
    "degC": """degc; grad c; grad celsius; deg c; celsius; grados c; degres c; gradi c; graus c; degree c; degrees c;
        degree celsius; degrees celsius; deg celsius""",
    "degF": """degf; deg f; degree f; degrees f; fahrenheit; deg fahrenheit; degree fahrenheit; degrees fahrenheit;
        grad f; grad fahrenheit; grados f""",
    "kgf": "kgf; kg f; kg force; кгс",
    "lbf": "lbf; lb f; lbs f; lbs force; lb force; pound force; pounds force", "gf": "gf; g f; гс", "ozf": "ozf",
    "%": "prozent; percent; per cent; pct; porcentaje; pourcent", "K": "kelvin", "-": "dimensionless; none",
    "in": "inch; pulg", "kg": "kg; kgs; kilogram; kilograms; kilos", "g": "gm; gms", "lb": "lbs; pounds",
    "oz": "ounces", "kip": "kips", "tf": "tonf; ton force", "ppm": "microstrain; micro strain; \u03bcepsilon", "m": "м",
    "cm": "см", "mm2": "мм2", "cm2": "см2",
}  # fmt: skip
#: The same for compression, where machines count pushing as positive.
COMPRESSIVE: dict[str, str] = {
    "strain": """compressive strain; compression strain; compressive strain compression; stauchung; nennstauchung;
        deformacion por compresion; deformacion de compresion; deformation en compression; deformazione a
        compressione; deformacao de compressao; ecrasement; taux de compression; 压缩应变; 圧縮ひずみ; 圧縮歪み;
        деформация
        сжатия""",
    "extension": """compressive extension; compressive displacement; compression; compression displacement; deflection;
        deflexion; stauchweg; eindruckweg; einfederung; extension por compresion; deplacement de compression;
        extension de compression; flecha; 压缩位移; 压缩变形; 压缩量; 圧縮変位; 圧縮量""",
    "force": """compressive load; compressive force; compression load; compression force; normal force; axial force
        rheometer; druckkraft; normalkraft; stauchkraft; carga de compresion; fuerza de compresion; fuerza
        normal; force de compression; charge de compression; force normale; forza di compressione; forza normale;
        forca de compressao; forca normal; axialforce; fn; 压缩载荷; 压缩力; 圧縮荷重; 圧縮力; сила сжатия""",
    "stress": """compressive stress; compression stress; normal stress; druckspannung; stauchspannung; stauchharte;
        esfuerzo de compresion; tension de compresion; contrainte de compression; sforzo di compressione;
        tensione di compressione; tensao de compressao; 压缩应力; 圧縮応力; напряжение сжатия""",
}
#: What counts as a stress of compression beside a volume ratio, and nowhere else: a bulge has a pressure too.
PRESSURES = """pressure; hydrostatic pressure; mean pressure; druck; hydrostatischer druck; presion;
    presion hidrostatica; pression; pression hydrostatique; pressione; pressione idrostatica; pressao;
    pressao hidrostatica"""
#: Columns of a pushed sheet, of a press and of a mold, for which no test of a fabric is asked.
READINGS: dict[str, str] = {
    "depth": """penetration; penetration depth; indentation depth; indentation; deflection; ball displacement;
        ball travel; punch displacement; punch travel; plunger displacement; plunger travel; durchbiegung;
        stempelweg; kugelweg; tiefe; eindringtiefe; eindrucktiefe; profondeur; profondeur de penetration;
        enfoncement; profundidad; profundidad de penetracion; profondita; profondita di penetrazione;
        profundidade; profundidade de penetracao; derinlik; 深度; 压入深度; 押込み深さ; 押し込み深さ; diepte;
        indrukdiepte; glebokosc; zaglebienie; syvyys; hloubka; djup; 깊이; 압입 깊이""",
    "stroke": """press stroke; hub; hubweg; pressenhub; schliessweg; course; carrera; corsa; curso;
        strok; 行程; zdvih; 스트로크""",
    "pressure": """contact pressure; film pressure; druck; kontaktdruck; flachenpressung; pression;
        pression de contact; presion; presion de contacto; pressione; pressione di contatto; pressao;
        pressao de contato; basinc; 压力; 面圧; druk; contactdruk; nacisk; cisnienie; paine; tlak; tryck; 압력; 면압""",
    "power": """heater power; heating power; total power; wattage; leistung; heizleistung; gesamtleistung;
        puissance; puissance de chauffe; potencia; potenza; guc; 功率; 電力; 加热功率; vermogen; moc;
        moc grzewcza; teho; vykon; effekt; 전력""",
    "thickness": "dicke; epaisseur; espesor; spessore; espessura",
    "height": "hohe; hauteur; altura; altezza",
    "contact": """kontakt; contacto; contatto; contato; ink; tinte; encre; tinta; touch; touches; beruhrung; kosketus;
        접촉""",
    **{
        f"{axis}0": "; ".join(f"{word} {axis}; {axis} {word}" for word in ("flat", "undeformed", "undef", "reference",
        "ref", "initial", "inicial")) + f"; {axis}ref" for axis in "xy"
    },
    **{
        axis: f"draped {axis}; deformed {axis}; {axis} draped; {axis} deformed; {axis} def; {axis}def; {axis} final; "
        f"{axis} coordinate; "
        f"coordinate {axis}; coord {axis}" for axis in "xyz"
    },
    **{
        move: f"displacement {axis}; {axis} displacement; disp {axis}; d{axis}; delta {axis}; verschiebung {axis}"
        for move, axis in zip("uvw", "xyz", strict=True)
    },
}  # fmt: skip
#: The same across the load: how much wider or narrower the specimen has become, beside the strain along it.
ACROSS: dict[str, str] = {
    "strain": """lateral strain; transverse strain; transversal strain; cross strain; width strain; strain across;
        engineering lateral strain; engineering transverse strain; querdehnung; querverformung; breitendehnung;
        laterale dehnung; deformacion transversal; deformacion lateral; deformation transversale;
        deformation laterale; deformazione trasversale; deformazione laterale; deformacao transversal;
        deformacao lateral""",
    "stretch": """f22; lateral stretch; transverse stretch; transversal stretch; lateral stretch ratio; transverse
        stretch ratio; width ratio; querstreckung; querstreckverhaltnis""",
}
#: Known, and no reading of the test: their names are told, nothing is asked.
ASIDE = """date; datum; fecha; data; clock; uhrzeit; heure; hora; ora; time of day; date time; datetime; datum
        uhrzeit; point; points; point no; data point; index; no; nr; n; row; id; messpunkt; punkt; punto; ponto;
        lfd nr; line; record; scan; frame; image; bild; photo; image no; comment; comments; kommentar; bemerkung;
        bemerkungen; remark; remarks; note; notes; comentario; comentarios; observaciones; observacoes;
        commentaire; remarque; commento; nota; energy; work; arbeit; energia; energie; travail; lavoro; trabalho;
        tenacity; feinheitsfestigkeit; status; flag; event; marker; step; segment; phase; power; torque; moment;
        drehmoment; modulus; modul; storage modulus; loss modulus; complex modulus; tan delta; tan;
        tan d; loss factor; complex viscosity; phase angle; raw phase; speichermodul; verlustmodul; verlustfaktor;
        count; zahler; counter; humidity; luftfeuchte; feuchte; humedad; humidite;
        umidita; umidade; operator; pruefer; prufer; x; y; z; poisson ratio; querkontraktionszahl; area; flache;
        width; breite; ancho; largeur; larghezza; largura; thickness; dicke; unnamed; sr; serial; s no; 날짜;
        paivamaara; paivays"""

#: Words that machines put beside the name of a channel and that change nothing.
FILLERS = """analog; analogue; digital; ch; channel; sensor; kanal; canal; canale; raw; filtered; measured; actual;
        current; istwert; messwert; wert; value; reading; signal; data; average; avg; mean; mittel; mittlere;
        moyenne; media; medio; medie; total; de; del; der; die; das; the; of; en; le; la; specimen; sample; probe;
        engineering; nominal; axial; engr; eng; gl; dic; lvdt; cam; tech; technical; major; standard; por; a; di;
        traccion; traction; trazione; tracao; machine; crosshead; traverse; traversen; actuator; 1; 01"""
#: What reads a specimen's own elongation, in words beside it: surer than the machine's.
GAUGES = """extensometer; videoextensometer; video extensometer; video; optical; laser; clip on; clip gauge; clip gage;
    non contact; contactless; extensometro; extensometre; estensometro; laserextensometer; optisch; optische;
    feindehnung; dic; image correlation; bildkorrelation"""
#: What is on a specimen, where a file states by what its strain was read; beside these what reads it.
MARKS = """marks; marker; markers; pins; dots; speckle; speckles; correlation; dic; camera; cameras; yes; marken;
    messmarken; bildkorrelation; marcas; marques; marcatori"""
#: Words that tell a second reading of the same quantity: beside a column without them, which one is meant is asked.
MENDED = """corrected; tared; zeroed; compensated; net; korrigiert; korrigierte; tariert; tarierte; genullt;
        kompensiert; kompensierte; corregida; corregido; tarada; tarado; compensada; compensado; corrigee; corrige;
        taree; compensee; corretta; corretto; tarata; tarato; corrigida; corrigido"""
#: The measure of a strain or stress, as image correlation and offices write it beside the name; without a name where
#: hf does not read it.
MEASURES: dict[str, dict[str, str]] = {
    "strain": {
        "true strain": """natural; naturliche;
            true; log; logarithmic; hencky; ln; wahr; wahre; logarithmisch; logarithmische; verdadera;
            verdadeira; vraie; vera; logaritmica; logarithmique""",
        "green strain": "green; lagrange; lagrangian; lagrangienne; lagrangiana",
        "": "almansi; eulerian",
    },
    "stress": {
        "true stress": "true; cauchy; wahr; wahre; verdadero; verdadera; verdadeira; vraie; vero; vera",
        "": "kirchhoff; pk2",
    },
}

#: What a test is called, by its kind: tried on words of names, settings and columns.
TESTS: dict[str, str] = {
    "biaxial-general": "biaxial general; general biaxial",
    "biaxial": """biaxial; equibiaxial; equi biaxial; equal biaxial; equibiaxial tension; aquibiaxial; biaxial gleich;
        equibiaxiale; biaxiale; biaxialer; biaxiaux; biassiale; inflation; bulge; cruciform; kreuzprobe; msaj;
        en 17117 1""",
    "simple-shear": """simple shear; einfache scherung; einfacher schub; lap shear; corte simple; cisaillement simple;
        taglio semplice; cisalhamento simples; quad lap shear; quadruple shear; quad shear; double lap shear;
        iso 1827""",
    "shear": """shear; planar; planar tension; pure shear; planar shear; planarzug; reine scherung; corte puro;
        cisaillement pur; taglio puro; cisalhamento puro; wide strip; strip biaxial""",
    "confined-compression": "confined compression; oedometer; oedometric; eingespannte stauchung",
    "volumetric": "volumetric; volumetric compression; hydrostatic; volumetrisch; volumetrico; volumetrique",
    "compression": """compression; compressive; uniaxial compression; compression test; druckversuch; druck;
        druckprufung; stauchversuch; stauch; compresion; essai de compression; compressione; compressao; 压缩;
        iso 3386; iso 3386 1; iso 844; 压缩试验; 圧縮; 圧縮試験; сжатие; basma testi;
        basma deneyi; drukproef; sciskanie; proba sciskania""",
    "uniaxial": """uniaxial; uniaxial tension; tension; tensile; tensile test; tensile testing; strip;
        strip test; strip method; bias extension; bias tension; zugversuch; zug; zugprufung; streifenzugversuch;
        streifenzug; traccion; ensayo de traccion; essai de traction; traction; trazione; prova di trazione;
        tracao; ensaio de tracao; strip tensile; iso 13934 1; iso 37; astm d412; iso 527; astm d5035;
        iso 20932 1; en 14704 1; iso 1798; astm d638; astm d882; 拉伸; 拉伸试验; 単軸引張; 引張; 引張試験; растяжение;
        cekme testi; cekme deneyi; cekme; trekproef; rozciaganie; proba rozciagania; vetokoe; tahova zkouska; zkouska
        tahem; dragprov; 인장; 인장시험; 인장 시험""",
}
DIRECTIONS: dict[str, str] = {
    "warp": """warp; wale; wales; machine; md; machine direction; length; lengthwise; longitudinal;
        longitudinal direction; rd; rolling direction; laufrichtung; produktionsrichtung; maschinenrichtung;
        sens machine; direccion de maquina; direzione macchina; walzrichtung; calendering; calender direction;
        calendering direction; kette; kettrichtung; in kettrichtung; kett; stabchenrichtung; maschenstabchen;
        langs; langsrichtung; urdimbre; columna; columnas; chaine; sens chaine; colonne; ordito; urdume; teia;
        cozgu; cozgu yonu; 经向; 経; たて; タテ; 経方向; たて方向;
        タテ方向; 经; ketting; kettingrichting; schering; osnowa; kierunek osnowy;
        wzdluz osnowy; loimi; osnova; po osnove; varp; 경사; 경사방향""",
    "weft": """weft; width; fill; filling; course; courses; cd; xd; cross; crosswise; cross machine; cross direction;
        td; transverse; transverse direction; widthwise; schuss; schussrichtung; in schussrichtung;
        reihenrichtung; maschenreihe; quer; querrichtung; trama; pasada; pasadas; trame; sens trame;
        sens travers; rangee; fila; atki; atki yonu; 纬向; 緯; よこ; ヨコ; 緯方向; よこ方向;
        ヨコ方向; 纬; inslag; inslagrichting; watek;
        kierunek watku; wzdluz watku; kude; utek; po utku; vaft; 위사; 위사방향""",
    "bias": """bias; bias extension; bias tension; bias direction; bias cut; bias strip; diagonal; diagonal direction;
        schrag; schragrichtung; diagonalrichtung; biais; sens biais; sesgo; al sesgo; sbieco; vies""",
}
BRANCHES: dict[str, str] = {
    "load": """load; loading; up; forward; extension; stretch; belastung; belasten; hin; hinweg; carga; charge;
        aller; carico; andata; subida; +1""",
    "unload": """unload; unloading; down; back; return; recovery; entlastung; entlasten; ruck; ruckweg; descarga;
        decharge; retour; scarico; ritorno; descida; -1""",
}
#: Those of the words below that a specimen may be called by: a size, a letter, a first name.
NAMES = "s; n; max"
#: Words that begin a closing row of a table of readings.
CLOSING = """mean; mw; vk; s; xbar; average; avg; sd; std; stdev; std dev; stddev; standard deviation; s d; cv;
    c v; cov; coefficient
        of variation; variance; median; min; minimum; max; maximum; range; count; n; sum; total; mittelwert;
        mittel; standardabweichung; stabw; streuung; variationskoeffizient; vk; summe; anzahl; media; promedio;
        desviacion estandar; desviacion; desv est; coeficiente de variacion; mediana; minimo; maximo; suma;
        moyenne; ecart type; ecart; coefficient de variation; mediane; somme; deviazione standard; dev std;
        somma; desvio padrao; desvio; soma; end; ende; end of file; end of data; eof; fin; fine; fim; x quer; xs"""
