"""What comments say: kinds, titles, directives and tools, word by word and over the real programs."""

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from chipbreak.operations.kinds import (
    Kind,
    KindRules,
    OperationMark,
    ToolNote,
    directive,
    kind_of_text,
    operation_title,
    tool_text,
)
from chipbreak.text.diagnostics import RefusalError

NO_RULES = KindRules()
HERE = Path(__file__).parent
COMMENT = re.compile(r"\(((?:[^()\r\n]|\([^()\r\n]*\))*)\)|;([^\r\n]*)")


def kind_name(text: str) -> str:
    found = kind_of_text(text, NO_RULES)
    return found.kind.value if found else "-"


def title_name(text: str) -> str:
    mark = operation_title(text)
    return ("start" if mark.is_start else "end") if mark else "-"


KINDS = [
    ("rough-english", "rough", "ROUGH OD|Roughing|RGH|OD AND FACE RGH. TURN|RGHG|REROUGH FLOOR|OPTIROUGH"),
    ("rough-misspelt", "rough", "WRAPPED POCKET ROUGHNIG|ROUHGING|ROUGING|RUFF OD|ROGHING"),
    ("rough-strategies", "rough", "ADAPTIVE2|3D Adaptive|POCKET CLEARING|CLEARING 2|HEM SLOT|DYNAMIC MILL"),
    ("rough-powermill", "rough", "AREA CLEARANCE|1-MODEL AREA CLEARANCE|Toolpath Name: rest-area-clear"),
    ("rough-german", "rough", "SCHRUPPEN|AUSSENSCHRUPPEN|VORDREHEN"),
    ("rough-dutch", "rough", "VOORDRAAIEN|voordraaien buiten"),
    ("rough-romance", "rough", "DESBASTE EXTERNO|EBAUCHE|\xc9BAUCHE EXT|SGROSSATURA"),
    ("rough-in-a-tool-name", "rough", "ROUGHING END MILL|MILL_D10_ROUGH|T1 80 DEG ROUGH TURNING TOOL"),
    ("rough-before-allowance", "rough", "ROUGH OD LEAVE .010 FOR FINISH"),
    ("rough-stock-to-leave", "rough", "T2| 1/2 ENDMILL|H0|XY STOCK TO LEAVE - .01|Z STOCK TO LEAVE - 0."),
    ("finish-english", "finish", "FINISH PASS|OD FIN|FIN. BORE|FIN|Finishing|FINISH BORE|FINSH OD|FINE BORE"),
    ("finish-german", "finish", "SCHLICHTEN|PROFIL FEINSCHLICHTEN"),
    ("finish-dutch", "finish", "NADRAAIEN"),
    ("finish-romance", "finish", "ACABAMENTO INTERNO|ACABADO|AFINADO EXTERIOR|FINITION|FINITURA"),
    ("finish-and-rough", "finish", "ROUGH AND FINISH OD"),
    ("finish-no-stock", "finish", "T2| 1/2 EM|H0|XY STOCK TO LEAVE - -.0005|Z STOCK TO LEAVE - 0."),
    ("finish-a-hair", "finish", "T2| 1/2 EM|H0|XY STOCK TO LEAVE - .0001|Z STOCK TO LEAVE - .0006"),
    ("finish-a-hair-in-mm", "finish", "T2| 12MM EM|H0|XY STOCK TO LEAVE - .02|Z STOCK TO LEAVE - 0."),
    ("rough-in-mm", "rough", "T2| 12MM EM|H0|XY STOCK TO LEAVE - .2|Z STOCK TO LEAVE - 0."),
    ("rough-in-inches", "rough", "T2| 1/2 EM|H0|XY STOCK TO LEAVE - .001|Z STOCK TO LEAVE - 0."),
    ("semi-finish", "semi-finish", "SEMI-FINISH|SEMI FINISH WALLS|SEMIFIN|SEMI FIN.|SEMI PASS|VORSCHLICHT"),
    ("semi-finish-romance", "semi-finish", "SEMI-ACABADO|DEMI-FINITION|SEMIFINITURA"),
    ("drill", "drill", "DRILL 4X|DRILL4|PECK DRILL|PRE-DRILL|SPOT 2X|CENTER DRILL|REAM 2X|BORE1|BROCA"),
    ("drill-for-a-tap", "drill", "TAP DRILL|DRILL M8 TAP HOLES"),
    ("thread", "thread", "THREAD2|ID THREAD|THREADING|TAP 4X HOLES|RIGID TAPPING|GEWINDE M6|ROSCA EXT"),
    ("probe", "probe", "PROBE1|WCS PROBE|Probing the bore|PROBE BORE"),
    ("none-by-feature-only", "-", "2D CONTOUR (2)|POCKET2|FACE1|OD TURN|2D-FACE|FLAT END MILL|BORING BAR"),
    ("none-freecad-end", "-", "Finish operation: Rough pocket|finish operation|FINISH OPERATION: Finish"),
    ("none-finished", "-", "FINISHED SIZE 2.5|FINISHED DIA|SURFACE FINISH 32|FINISH DIA 2.5|FIN DE PROGRAM"),
    ("none-fins", "-", "COOLING FINS|FINGER|DEFINE SETUP|FINAL"),
    ("none-semi", "-", "SEMICOLON FORMAT|SEMI AUTOMATIC"),
    ("none-rough", "-", "THROUGH HOLE|TROUGH|ROUGHNESS 1.6|ROUGHLY 5MM|ROUGH STOCK 100|AFTER ROUGHING"),
    ("none-clearing", "-", "AIR CLEARING|CHIP CLEARING|DYNAMIC WORK OFFSET|ADAPTIVE FEED ON|HEMISPHERE"),
    ("none-clearance", "-", "AREA CLEARANCE HEIGHT|CLEARANCE"),
    ("none-drill", "-", "THREADED|TAPER 5 DEG|COLT.TAP|SELF-TAPPING SCREWS|THREAD RELIEF|PROBED"),
    ("none-prose", "-", "this line is used to start a drilling cycle|the part must be rough here and there"),
    ("none-commands", "-", "MSG, ROUGH|debug, Finish Z|print, finish|LOG, drill|#1 finish|=6 Roughing"),
    ("none-empty", "-", "| |(|)|-|1234|DATE: 2020-01-01"),
]


@pytest.mark.parametrize(("kind", "texts"), [row[1:] for row in KINDS], ids=[row[0] for row in KINDS])
def test_words_name_kinds(kind, texts):
    # a Mastercam list line has bars of its own
    for text in [texts] if "STOCK TO LEAVE" in texts else texts.split("|"):
        assert (text, kind_name(text)) == (text, kind)


@pytest.mark.parametrize("encoding", ["cp932", "utf-8"])
@pytest.mark.parametrize(
    ("text", "kind"),
    [
        *(("荒加工", "rough"), ("内径粗", "rough"), ("ｱﾗｶｺｳ", "rough"), ("荒 仕上代 0.2", "rough")),
        *(("外径仕上げ", "finish"), ("ｼｱｹﾞ", "finish"), ("中仕上", "semi-finish")),
        *(("ドリル", "drill"), ("ねじ切り", "thread")),
        *(("表面粗さ", "-"), ("仕上代 0.2", "-"), ("アラーム", "-")),
    ],
)
def test_japanese_is_read_from_either_encoding(text, kind, encoding):
    as_latin_1 = text.encode(encoding).decode("latin-1")
    assert kind_name(as_latin_1) == kind_name(text) == kind
    assert title_name(as_latin_1) == ("-" if kind == "-" else "start")
    assert kind_name("\x91ende\x92") == "-"  # Windows quotation marks make a kanji with the e


def test_the_reason_names_the_word_and_the_comment():
    found = kind_of_text("WRAPPED POCKET ROUGHNIG", NO_RULES)
    assert found.reason == '"ROUGHNIG" in the comment "WRAPPED POCKET ROUGHNIG"'
    assert kind_of_text("荒\x07加工", NO_RULES).reason == '"荒" in the comment "荒?加工"'


def test_rules_of_the_profile_come_first():
    rules = KindRules.from_profile({"finish": [r"\bF\d+$"], "rough": ["BLOCKING", "ROUGH"]})
    assert kind_of_text("blocking out", rules).kind is Kind.ROUGH
    found = kind_of_text("ROUGH HOLE F2", rules)
    assert found.kind is Kind.FINISH
    assert found.reason == '"F2" in the comment "ROUGH HOLE F2" (profile, operations.finish)'
    assert kind_of_text("DRILL1", rules).kind is Kind.DRILL
    japanese = KindRules.from_profile({"rough": ["下加工"]})
    assert kind_of_text("下加工".encode("cp932").decode("latin-1"), japanese).kind is Kind.ROUGH


@pytest.mark.parametrize(
    ("profile", "code"),
    [
        *(({"ruogh": ["X"]}, "SET020"), ({"unknown": ["X"]}, "SET020"), ({"rough": ["("]}, "SET021")),
        *(({"rough": ["X*"]}, "SET021"), ({"rough": [""]}, "SET021"), ({"rough": "ROUGH"}, "SET021")),
    ],
)
def test_bad_rules_are_refused(profile, code):
    with pytest.raises(RefusalError) as caught:
        KindRules.from_profile(profile)
    assert caught.value.code == code


TITLES = [
    ("fusion-names", "2D CONTOUR3|FACE1|ADAPTIVE2|POCKET2|BORE1|DRILL4|PROFILE ROUGHING 4|TRACE1"),
    (
        "after-a-dash",
        "2D CONTOUR1 - FINISHING|POCKET 2 / ROUGH|2D CONTOUR1: FINISH|SIDE A - ROUGHING|RAMP1 - SEMI-FINISH",
    ),
    ("passes", "BOSS - FINISH PASS|STEP 2 ROUGH OUT|KEYWAY ROUGH CUTS|WALL FINISHING PASSES"),
    ("fusion-copies", "2D CONTOUR (2)|2D POCKET2 (3)|2D Contour8 2|ADAPTIVE (2) (2)"),
    ("fusion-others", "PARALLEL1|SCALLOP3|MORPHED SPIRAL1|FLOW1|PENCIL|RAMP2|RADIAL1|SPIRAL1|FLAT2|SLOT1"),
    ("fusion-more", "SWARF1|ENGRAVE1|THREAD2|CHAMFER1|STEEP AND SHALLOW1|2D-CONTOUR|2D Pocket tabs"),
    ("vcarve", "Profile 1|V-Carve 2|VCARVE1|FLUTING 1|Pocket 3"),
    ("fusion-lathe", "TURNING FACE1|GROOVE2|SINGLE GROOVE1|PART1|PROFILE FINISHING2"),
    ("hand-by-kind", "ROUGH TURN|OD ROUGH RIGHT|FINISH PASS|RGH FACE|Finishing|ROUGHING CYCLE|CNC ROUGHNIG"),
    ("hand-by-feature", "DRILL 4X|FACE, TURN|ID TURN|CUT OFF|PART OFF|CHAMFER|DEBURR|MILL CLEARANCE|part"),
    (
        "hand-with-tool",
        "ROUGH POCKET 1/2 E.M.|FINISH WALLS WITH 3/8 E.M|MILL SLOT 1/4 E. M.|POCKET - 6MM E.M.",
    ),
    ("hand-foreign", "DESBASTE EXTERNO|PROFIL SCHLICHTEN|VOORDRAAIEN"),
    ("hand-numbered", "OP10 FACE|OP1: TOREC|OPERATION 2|OPERATION ONE - DRILLING|OP. 2 FLANGE|Operation: A"),
]
NO_TITLES = [
    ("fusion-tools", "T1 D=50.8 CR=0. - ZMIN=0. - FACE MILL"),
    ("mastercam-tools", "T2| 1/2 FLAT ENDMILL|H0|XY STOCK TO LEAVE - .005"),
    ("hand-tools", 'DRILL 1/4"¦12MM DRILL¦ROUGHING END MILL¦REAMER¦BORING BAR¦DRILL 5¦T8 - BORING BAR'),
    ("hand-em", '1/2 E.M.¦ROUGH 1/2 E.M.¦ROUGHING E.M. 1/2¦1/4" 2 FLUTE STUBBY E.M.¦T5 1/2 E.M. ROUGH'),
    ("dates", "DATE: 2015-06-26¦19.04.2010¦2024-06-13 13:38"),
    ("program-names", "FLANGE OP.2¦PROGRAM NAME FLANGE¦PART 2¦DRILL.NC¦O0358"),
    ("headers", "MACHINE¦VENDOR AUTODESK¦MODEL GENERIC 3-AXIS ROUTER¦FANUC 0M"),
    ("setup-notes", "USING HIGH FEED G1 F5000.¦STOCK/BLOCK 100X50¦FACE OF JAWS¦DRILL DEPTH¦OD INSERT"),
    ("setup-more", "TURN ON COOLANT¦ROUGH STOCK¦PROBE FEED RATE¦FINISH Z: 1.5¦FINISH = 2¦turn comp off"),
    ("ends", "END OF PROGRAM¦END¦FIN¦DONE DRILLING¦FINISHED"),
    ("prose", "when drilling this hole you must peck¦MSG, DRILLING¦a b c d e f g h i j k DRILLING"),
]


@pytest.mark.parametrize("texts", [row[1] for row in TITLES], ids=[row[0] for row in TITLES])
def test_titles_start_operations(texts):
    for text in texts.split("|"):
        assert operation_title(text) == OperationMark(True, text), text


@pytest.mark.parametrize("texts", [row[1] for row in NO_TITLES], ids=[row[0] for row in NO_TITLES])
def test_other_comments_are_no_titles(texts):
    for text in texts.split("¦"):
        assert operation_title(text) is None, text


@pytest.mark.parametrize(
    ("text", "mark"),
    [
        ("begin operation: Rough pocket", OperationMark(True, "Rough pocket")),
        ("Begin Operation: Flat (2)", OperationMark(True, "Flat (2)")),
        ("Finish operation: Rough pocket", OperationMark(False, "Rough pocket")),
        ("FINISH OPERATION", OperationMark(False, "")),
        ("Toolpath name      = Boring_2", OperationMark(True, "Boring_2")),
        ("No. 3: Drill Top Hole", OperationMark(True, "Drill Top Hole")),
    ],
)
def test_marks_of_cam_systems_carry_the_label(text, mark):
    assert operation_title(text) == mark


DIRECTIVES = {
    Kind.ROUGH: ["OP ROUGH", "op rough", " Op  Roughing "],
    Kind.SEMI_FINISH: ["OP SEMI-FINISH", "OP SEMI FINISH", "op semifinish"],
    Kind.FINISH: ["OP FINISH"],
    Kind.DRILL: ["OP DRILL"],
    Kind.THREAD: ["OP THREAD"],
    Kind.PROBE: ["OP PROBE", "OP PROBING"],
    Kind.UNKNOWN: ["OP UNKNOWN"],
}
ORDINARY = ["OP 10", "OP2", "OP. 2 FLANGE", "OP", "OP STOP", "OP ONE", "OP FACE", "OP FINISH BORE", "OPROUGH"]


@pytest.mark.parametrize("kind", Kind)
def test_directives(kind):
    assert {directive(text) for text in DIRECTIVES[kind]} == {kind}


@pytest.mark.parametrize("text", [*ORDINARY, "STOP ROUGH", "OP FINISHED", "OP ROUGH 2"])
def test_ordinary_comments_are_no_directives(text):
    assert directive(text) is None


@pytest.mark.parametrize("text", ["OP ROUHG", "op finsih", "OP DRIL", "OP SEMIFINSH"])
def test_a_misspelt_directive_is_refused(text):
    with pytest.raises(RefusalError) as caught:
        directive(text)
    assert caught.value.code == "OPS001"


# text: number, diameter, unit, corner radius, taper, type
TOOLS = {
    "T1 D=50.8 CR=0. - ZMIN=0. - FACE MILL": (1, 50.8, None, 0.0, None, "face mill"),
    "T1 D=0.1563 CR=0. TAPER=118DEG - ZMIN=-3.2345 - DRILL": (1, 0.1563, None, 0.0, 118.0, "drill"),
    "T3  D=2 CR=1 - ZMIN=-12.7 - ball end mill": (3, 2.0, None, 1.0, None, "ball end mill"),
    "T12  D=4. CR=0. - ZMIN=-18. - SCHAFTFRSER": (12, 4.0, None, 0.0, None, "flat end mill"),
    "T4 D=8. CR=0. - ZMIN=-1. - WORKHOLDER": (4, 8.0, None, 0.0, None, "workholder"),
    "T2| 1/2 FLAT ENDMILL|H0|XY STOCK TO LEAVE - .005": (2, 0.5, "in", None, None, "flat end mill"),
    "T212 |    3. FLAT ENDMILL | H0": (212, None, None, None, None, "flat end mill"),
    "TOOL - 1 DIA. OFF. - 1 LEN. - 1 DIA. - .5": (1, 0.5, None, None, None, None),
    "TOOL NO. - 1 OFFSET - 1": (1, None, None, None, None, None),
    "T01 = 80 DEG ROUGH TURNING TOOL": (1, None, None, None, None, "turning tool"),
    "TO1 = 80* Rough Turning Tool, Nose Radius: .0315": (1, None, None, 0.0315, None, "turning tool"),
    'T08 - 3/4" BORING BAR': (8, 0.75, "in", None, None, "boring bar"),
    "T12 - CNMG 432 OD TURN": (12, None, None, None, None, "turning tool"),
    "T0101 - GROOVING TOOL": (None, None, None, None, None, "grooving tool"),
    "Tool Number : 4": (4, None, None, None, None, None),
    "DIA: 10": (None, 10.0, None, None, None, None),
    "TOOL TYPE : BALLNOSED": (None, None, None, None, None, "ball end mill"),
    "TOOL TYPE : TIP RADIUSED": (None, None, None, None, None, "bull nose end mill"),
    "TIP RADIUS: 1.5": (None, None, None, 1.5, None, None),
    "TC: 6MM Chamfer Mill": (None, 6.0, "mm", None, None, "chamfer mill"),
    '1-1/2" SHELL MILL': (None, 1.5, "in", None, None, "face mill"),
    "T14 - CHIP FAN": (14, None, None, None, None, "chip fan"),
    "T14 | CHIP FAN | H14": (14, None, None, None, None, "chip fan"),
    "BLOW-OFF FAN": (None, None, None, None, None, "chip fan"),
    "AIR NOZZLE": (None, None, None, None, None, "air nozzle"),
    "1/2 BALL E.M.": (None, 0.5, "in", None, None, "ball end mill"),
    "1/2 FLAT EM": (None, 0.5, "in", None, None, "flat end mill"),
    "1/2 BULL E. M.": (None, 0.5, "in", None, None, "bull nose end mill"),
    "1/2 E.M": (None, 0.5, "in", None, None, "end mill"),
    "LET. B DRILL": (None, None, None, None, None, "drill"),
    "M10 TAP": (None, None, None, None, None, "tap"),
    "T0 : 3.175": (0, 3.175, None, None, None, None),
}


@pytest.mark.parametrize("text", TOOLS)
def test_tool_comments(text):
    number, diameter, unit, radius, taper, kind = TOOLS[text]
    assert tool_text(text) == ToolNote(number, diameter, radius, taper, kind, text, unit)


NO_TOOLS = (
    "T1¦T1 M6¦T0101¦DRILL 4X¦SPOT 2X HOLES¦CENTER DRILL¦TOOL LIST¦Tool change¦LOAD T3 - S580¦PROBE¦FACE1¦¦"
    "T1 is for facing and the threading tool is T4¦Tool 2mm dia.¦"
    "AIR BLAST ON¦BLOW OFF PART¦COOLING FAN¦Finish operation: TC: 6mm Endmill¦Begin operation: 6mm Endmill¦"
    "'operation:tool_type', 'face mill'"
)


def test_other_comments_describe_no_tool():
    assert [text for text in NO_TOOLS.split("¦") if tool_text(text)] == []
    assert tool_text("T1 1/0 END MILL").diameter is None


@given(st.text(st.characters(max_codepoint=255)) | st.text('OPT 1/2-."=()DIARGHFNSEMUL|:,', max_size=40))
def test_no_text_raises_anything_but_a_refusal(text):
    kind_of_text(text, NO_RULES)
    operation_title(text)
    tool_text(text)
    try:
        directive(text)
    except RefusalError as refusal:
        assert refusal.code == "OPS001"


def corpus_comments(path: Path) -> list[str]:
    return [(a or b).strip() for a, b in COMMENT.findall(path.read_bytes().decode("latin-1"))]


BY_HAND = [
    line.split("\t") for line in (HERE / "kinds_by_hand.tsv").read_bytes().decode("latin-1").split("\n")[1:-1]
]


@pytest.mark.parametrize(("file", "comment", "kind", "title"), BY_HAND)
def test_comments_read_by_hand(file, comment, kind, title):
    assert (kind_name(comment), title_name(comment)) == (kind, title)


def test_every_comment_of_the_real_programs_is_read_without_a_refusal(corpus):
    for path in corpus:
        for comment in corpus_comments(path):
            kind_of_text(comment, NO_RULES)
            operation_title(comment)
            tool_text(comment)
            assert directive(comment) is None  # nobody there knows us


def test_the_comments_read_by_hand_are_real(corpus):
    """Those of the files that are in this corpus."""
    comments = {path.as_posix(): corpus_comments(path) for path in corpus}
    missing = [
        (file, comment)
        for file, comment, *_ in BY_HAND
        for path, found in comments.items()
        if path.endswith(f"/{file}") and comment not in found
    ]
    assert not missing
