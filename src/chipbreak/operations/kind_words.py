"""The words people and CAM systems write for kinds of operations, titles and tools: tables only.

A word list is a tuple of regular expressions; every list becomes one combined, compiled pattern.  What
the words mean is decided in :mod:`chipbreak.operations.kinds`.  The forms are those of
comments in real programs.
"""

from __future__ import annotations

from typing import Final

from chipbreak.text.any_case import AnyCase
from chipbreak.text.lazy_pattern import LazyPattern

# A word ends where the letters end: "DRILL4", "4XDRILL" and "D10_ROUGH" hold a word, "THROUGH" does not.
_LEFT: Final = r"(?<![^\W\d_])"
_RIGHT: Final = r"(?![^\W\d_])"
_DECIMAL: Final = r"\d+(?:\.\d*)?|\.\d+"
_FRACTION: Final = r"(?:\d+[ -])?\d+/\d+"


def _any(words: tuple[str, ...]) -> str:
    return "(?:" + "|".join(words) + ")"


def _kind(name: str, words: tuple[str, ...], japanese: str = "(?!)") -> str:
    """A named group; Japanese runs words together, so it stands without word ends."""
    return f"(?P<{name}>{_LEFT}{_any(words)}{_RIGHT}|{japanese})"


# --- kinds -----------------------------------------------------------------------------------------
_ROUGH: Final = (
    r"(?:RE-?|PRE-?|OPTI)?ROUGH(?:ING|NIG|IGN|IG|IN|NG|ER|S|-?OUT)?",
    r"(?:ROUHG|ROGH|ROUG|RUFF)(?:ING|NIG)",
    r"ROUHG|RUFF|RGHG?",
    r"ADAPTIVE(?!\s+(?:FEED|CONTROL|O[NF]))",
    r"(?<!AIR )(?<!CHIP )CLEARING(?!\s+(?:CHIPS?|PLANE|HEIGHT|MOVE|THE|MAX|MODE))",
    r"AREA[ -]CLEAR(?:ANCE)?(?!\s+(?:PLANE|HEIGHT|MOVE))",
    r"HEM",
    r"DYNAMIC\s+(?:MILL\w*|CORE\w*|POCKET\w*|AREA|FAC\w+|MOTION|REST\w*)|DYNAMIC(?=[\s\d]*$)",
    r"[^\W\d_]*SCHRUPP\w*|VORDREHEN|VORFR\S{1,3}SEN",
    r"VOORDRAAI\w*|VOORFREZEN",
    r"DESBAST\w*",
    r"[EÉ]BAUCH\w*",
    r"SGROSSA\w*",
)
_SEMI_FINISH: Final = (
    r"(?:SEMI|DEMI|PRE)[\s_-]?FIN(?:ISH\w*|ITION|ITURA)?",
    r"SEMI[\s_-]?ROUGH\w*",
    r"SEMI(?=\s*(?:PASS|CUT|\W*$))",
    r"(?:SEMI|PRE|PRÉ)[\s_-]?ACABA\w+",
    r"VOR-?SCHLICHT\w*",
)
_FINISH: Final = (
    r"FINISH(?:ING|NIG|IGN|IG|IN|NG|ER)?",
    r"(?:FINSH|FINSIH|FINIHS|FINNISH|FNISH)(?:ING)?",
    r"FIN\.?",
    r"FINE\s+BOR(?:E|ING)",
    r"[^\W\d_]*SCHLICHT\w*|FERTIG(?:DREHEN|FR\S{1,3}SEN)",
    r"NADRAAI\w*|NAFREZEN",
    r"ACABAMENTO|ACABADO|ACAB|AFINAD[OA]|AFINAR",
    r"FINITION|FINITURA",
)
_PROBE: Final = (r"(?<![_/.])PROB(?:E|ING)(?![_/.]|-[A-Z]|\s+MODE)", r"ANTASTEN")
_THREAD: Final = (
    r"THREAD(?:S|ING|MILL(?:ING)?)?(?!\s+(?:RELIEF|UNDERCUT|DIA|OD|MAJOR|MINOR|START|PITCH))",
    r"(?<!\.)(?<!SELF-)TAP(?:S|PING)?(?!\s+DRILL)",
    r"GEWINDE\w*|ROSCA\w*|FILETAGE|TARAUDAGE|FILETTATURA",
)
_DRILL: Final = (
    r"(?:(?:PRE|SPOT|CENT(?:ER|RE)|PECK)[ -]?)?DRILL(?:S|ING)?",
    r"SPOT(?:S|TING|-?FAC\w+)?",
    r"PECK(?:ING)?",
    r"REAM(?:S|ING|ER)?",
    r"(?:COUNTER|C'|C-)?BOR(?:E|ES|ING)(?!\s+(?:BAR|TOOL|INSERT|HEAD))",
    r"(?:COUNTER-?|C'|C-?)SINK(?:ING)?",
    r"BOHREN|BOHRER|TALADR\w*|FURA(?:R|CAO|ÇÃO)|BROCA|PER[CÇ]AGE|FORATURA",
)

# "粗" before a small letter is far more often a Windows quotation mark before an e.
_ROUGH_JA: Final = "[荒粗](?![さ度a-z])|(?<![ァ-ヺ])アラ(?!ー)|(?<![ｦ-ﾟ])ｱﾗ(?!ｰ)"
_FINISH_JA: Final = "仕上|シアゲ|ｼｱｹﾞ"

# The groups are named as the members of ``kinds.Kind``.
KIND_WORDS: Final = AnyCase(
    "|".join(
        (
            _kind("SEMI_FINISH", _SEMI_FINISH, "中仕上"),
            _kind("ROUGH", _ROUGH, _ROUGH_JA),
            _kind("FINISH", _FINISH, _FINISH_JA),
            _kind("PROBE", _PROBE),
            _kind("THREAD", _THREAD, "タップ|ﾀｯﾌﾟ|ねじ|ネジ|ﾈｼﾞ"),
            _kind("DRILL", _DRILL, "ドリル|ﾄﾞﾘﾙ"),
        )
    )
)
JAPANESE_KIND: Final = LazyPattern(f"{_ROUGH_JA}|{_FINISH_JA}|ドリル|ﾄﾞﾘﾙ|タップ|ﾀｯﾌﾟ|ねじ|ネジ|ﾈｼﾞ")

# Words that look like a kind and are none: blanked before the search.
FALSE_FRIENDS: Final = AnyCase(
    _LEFT
    + _any(
        (
            r"FINISH(?:ED|ES)",
            r"FINISH(?:ING)?[\s.]+(?:SIZE|DIA\w*|DEPTH|LENGTH|WIDTH|HEIGHT|ALLOWANCE|STOCK|TIME|DATE|POINT"
            r"|POSITION|PARTS?(?!\s*OFF)|LINE|PROG\w*|JOB|SPEC|RA|RMS)",
            r"(?:SURFACE|MILL|PROGRAM|JOB)\s+FINISH",
            r"(?:LEAV\w*|STOCK|ALLOWANCE|AUFMA\S+)\W.{0,40}?\b(?:FOR|TO|ZUM|F[UÜ]R)\s+(?:THE\s+)?(?:FIN|SCHLICHT)\w*",
            r"(?:BEFORE|AFTER|UNTIL|NO|NOT|WITHOUT|SAME\s+AS)\s+(?:THE\s+)?(?:SEMI-?)?(?:ROUGH|FINISH|DRILL|TAP|BOR|REAM)\w*",
            r"SCHLICHT\w*(?:AUFMA|ZUGABE)\w*",
            r"FIN\s+(?:DE|DEL|DU|PROG\w*)",  # French and Spanish: the end
            r"(?:COOLING|HEAT\s?SINK)\s+FINS?",
            r"ACABAD[OA]\s+SUPERFICIAL",
            r"ROUGH(?:\s+(?:STOCK|CAST\w*|SAW\w*|SIZE|BLANK|MATERIAL|FORG\w*|DIA\w*))",
        )
    )
    + "|仕上(?:げ?(?:[代寸径]|しろ|シロ)|が?り)"
)

# Mastercam's tool list says how much material is left.
STOCK_TO_LEAVE: Final = AnyCase(r"(?:XY\s+|Z\s+)?STOCK\s+TO\s+LEAVE\s*[-=:]?\s*(-?(?:" + _DECIMAL + r"))")

# --- comments that are no titles and name no kind -----------------------------------------------------
# Commands in comment form, and remarks about code: parameters, expressions.
ACTIVE_OR_CODE: Final = AnyCase(
    r"^\W*(?:(?:MSG|DEBUG|PRINT|LOG(?:OPEN|APPEND|CLOSE)?|ABORT|AXIS|PY)\s*,|PROBE(?:OPEN|CLOSE)\b)"
    r"|^'[\w:-]+'\s*,|^#\d|^[A-SU-Z]?\s*=|^MACRO\w+\s*=|O<|\$\{|#<|\[#|#\d+\s*=|\w\(\)"
)
# A sentence explains; a title names.
PROSE_WORDS: Final = AnyCase(
    r"\b(?:is|are|was|will|be|been|this|that|you|your|we|if|when|must|should|can|may|it|than|which|use[sd]?"
    r"|does|not|has|have|assumes?|only|need|until|because|ist|wird|sind|nicht)\b"
)

# --- operation titles -----------------------------------------------------------------------------------
LABELLED: Final = AnyCase(
    r"^(?:BEGIN\s+OPERATION\b\s*:?\s*(?P<begin>.*)"
    r"|FINISH\s+OPERATION\b\s*:?\s*(?P<finish>.*)"
    r"|TOOLPATH(?:\s+NAME)?\s*[:=-]\s*(?P<path>\S.*)"
    r"|NO\.\s*\d+:\s*(?P<numbered>\S.*))$"
)
_COUNT: Final = r"(?:\d+|(?:ONE|TWO|THREE|FOUR|FIVE|SIX|SEVEN|EIGHT|NINE|TEN)\b)"
_STRATEGY: Final = (
    r"FACE|FACING|CONTOUR|POCKET(?: CLEARING)?|ADAPTIVE(?: CLEARING)?|BORE|DRILL(?:ING)?|TRACE|PARALLEL"
    r"|SCALLOP|MORPH(?:ED SPIRAL)?|FLOW|PENCIL|RAMP|RADIAL|SPIRAL|HORIZONTAL|FLAT|CIRCULAR|SLOT|THREAD"
    r"|SWARF|ENGRAVE|CHAMFER|STEEP AND SHALLOW|BLEND|GEODESIC|DEBURR|ROTARY(?: \w+)?|MULTI-?AXIS \w+"
    r"|(?:WCS )?PROBE|(?:TURNING )?(?:PROFILE|GROOVE|FACE|THREAD|CHAMFER)(?: ROUGHING| FINISHING)?"
    r"|TURNING(?: PART)?|SINGLE GROOVE|CUTOFF|V-?CARVE|FLUTING|MOULDING|PRISM|INLAY"
)
STRATEGY_TITLE: Final = AnyCase(
    rf"^(?:(?:[23]D[ -]?)?(?:{_STRATEGY})(?:\d+(?: \d+)?(?:\s*\(\d+\))*|(?:\s*\(\d+\))+)"
    rf"|(?!DRILL )(?:[23]D[ -])?(?:{_STRATEGY}) \d+(?:\s*\(\d+\))*"  # "DRILL 5" is a size
    r"|PART\d+"  # "PART 2" is a workpiece
    rf"|[23]D[ -](?:{_STRATEGY})(?:\s+\S+){{0,4}}"
    r"|PARALLEL|SCALLOP|MORPHED SPIRAL|PENCIL|SWARF|STEEP AND SHALLOW"
    rf"|(?:OP|OPER|OPERATION)[\s.#:=-]*{_COUNT}.*"
    r"|OPERATION\s*[:=]\s*[^\W\d].*)$"
)
_PLACE: Final = (
    r"(?:[OI]\.?D\.?|OUTSIDE|INSIDE|INTERNAL|EXTERNAL|INNER|OUTER|FRONT|BACK|LEFT|RIGHT|TOP|BOTTOM|SIDE|FIRST"
    r"|SECOND|FINAL|LAST|MAIN|SUB|REST|\d+(?:ST|ND|RD|TH)|AND|&|WRAPPED|CORE|HIGH|LARGE|SMALL)"
)
_FEATURE: Final = (
    r"FAC(?:E|ING)(?!\s+(?:MILL|OF)\b)",
    r"TURN(?:ING)?(?!\s+(?:O[NF]|OFF|AROUND|OVER|PART|THE\s+PART)\b)",
    r"GROOV(?:E|ING)",
    r"CUT-?\s?(?:OFF|OUT)",
    r"PART(?:ING)?[\s-]?OFF|PARTING|PART(?=$)",
    r"CHAMFER(?:ING)?(?!\s+MILL\b)",
    r"DE-?BURR(?:ING)?",
    r"MILL(?:ING)?(?!\s+FINISH)",
    r"ENGRAV(?:E|ING)|KNURL(?:ING)?|UNDERCUT",
    r"(?:POCKET|PROFILE|CONTOUR|SLOT)S?|POCKETING|PROFILING|CONTOURING|SLOTTING",
)
_WORK: Final = _any((*_SEMI_FINISH, *_ROUGH, *_FINISH, *_PROBE, *_THREAD, *_DRILL, *_FEATURE))
# A title by feature or kind starts with it ("DRILL 4X", "OD ROUGH RIGHT") or ends with its -ING form.
HAND_TITLE: Final = AnyCase(
    rf"^(?:{_PLACE}\s+)*{_LEFT}{_WORK}{_RIGHT}.*$"
    r"|^(?:[^\W_][\w/.'&-]*(?:\s+|\s*[-:|/]\s+)){0,3}(?:SEMI-|PRE-)?(?:ROUGHING|ROUGHNIG|ROUGH|FINISHING|FINISH|TURNING|FACING|BORING|DRILLING"
    r"|TAPPING|THREADING|GROOVING|MILLING|PROFILING|REAMING|ADAPTIVE|CHAMFERING|DEBURRING|ENGRAVING"
    r"|[^\W\d_]*(?:SCHRUPPEN|SCHLICHTEN)|DESBASTE|ACABAMENTO|ACABADO)(?:\s+(?:PASS(?:ES)?|CUTS?|OUT))?\s*\d*$"
)
_NOTE: Final = (
    r"USING|STOCK|BLOCK|MATERIAL|DATE|TIME|PROG\w*|REV|RAPID|RETRACT|MOVES?|MOTION|OFFSETS?|PARAMETERS?"
    r"|VARIABLES?|NUMBER|FEED(?:RATE)?|RPM|SFM|RATE|COOLANT|SPINDLE|FIXTURE|VISE|JAWS?|NOTES?|CHECK|FAIL(?:ED|S)?"
    r"|FAILURE|DONE|MODE|TEST|ERROR|EXITING|RESULTS?|START|MACRO|SUB|DIRECTION|TOOL|BEGIN|SPEED"
    r"|COMP|CLAMPED|INSERTS?|HOLDER|CUTTER|DEG\.? TIP"
)
# What a title never holds: words of notes, a value ("DEPTH: 1.5"), a measure right after the feature.
NOT_A_TITLE: Final = AnyCase(
    rf"\b(?:{_NOTE})\b|=|:\s*[-+#%\[.\d]|,.*,|\?|!"
    rf"|^\W*{_WORK}{_RIGHT}\W*(?:DEPTH|LENGTH|DIA(?:M\w*|\.)?|RADIUS|WIDTH|ANGLE|PITCH|HEIGHT|SIZE|TIP|CENTERLINE)\s*$"
    r"|^FIN$|^[XYZ] FINISH$|\.(?:NC|TAP|NGC|MPF|TXT)$"
)

# --- tools ----------------------------------------------------------------------------------------------
# Canonical name (the words of Fusion's library) and how comments write it; the leftmost match wins, the
# first of the table at the same place.
_EM: Final = r"E\.?\s?M\.?"
TOOL_TYPES: Final = (
    ("flat end mill", rf"FLAT[\s-]*(?:END[\s-]*MILL|{_EM})|SCHAFTFR\S{{0,3}}SER"),
    ("ball end mill", rf"END_?MILL_SPHER|BALL[\s-]*(?:NOSED?|(?:END[\s-]*)?MILL|{_EM})|KUGELFR\S{{0,3}}SER"),
    (
        "bull nose end mill",
        rf"BULL[\s-]*(?:NOSE[\s-]*)?(?:(?:END[\s-]*)?MILL|{_EM})|BULL[\s-]*NOSE|TIP[\s-]*RADIUSED",
    ),
    ("end mill", r"END[\s_-]*MILL|E\.\s?M\.?|EM|(?:UNIVERSAL[\s-]*)?FR(?:AE|Ä)SER"),
    ("face mill", r"(?:FACE|SHELL)[\s-]*MILL|PLANFR\S{0,3}SER"),
    ("chamfer mill", r"CHAMFER[\s-]*(?:END[\s-]*)?(?:MILL|TOOL)|ENGRAVER|GRAVIERER"),
    ("thread mill", r"THREAD[\s-]*MILL"),
    ("slot mill", r"SLOT[\s-]*MILL|SLITTING\s+SAW"),
    ("dovetail mill", r"DOVETAIL\s+(?:MILL|CUTTER)"),
    ("spot drill", r"SPOT(?:TING)?[\s-]*DRILL"),
    ("center drill", r"CENT(?:ER|RE)[\s-]*DRILL"),
    ("drill", r"(?:TWIST\s+|TAP\s+)?DRILL|BOHRER"),
    ("reamer", r"REAMER"),
    ("counter sink", r"COUNTER-?\s?SINK|C'?SINK"),
    ("tap", r"(?:ROLL[\s-]*)?(?:FORM[\s-]*)?TAP"),
    ("boring bar", r"BORING[\s-]*BAR"),
    ("grooving tool", r"GROOV(?:E|ING)[\s-]*TOOL"),
    ("parting tool", r"(?:PART(?:ING)?|CUT)[\s-]*-?OFF[\s-]*TOOL|PARTING\s+TOOL"),
    ("threading tool", r"THREAD(?:ING)?\s+TOOL"),
    ("turning tool", r"TURN(?:ING)?\s+TOOL|[CDSTVWR][NCP][MGUE][AGMTX](?=[\s-]*\d)"),
    ("probe", r"PROBE"),
    ("chip fan", r"(?:CHIP|BLOW[\s-]*OFF|CLEANING|COOLANT)[\s-]*(?:FAN|BLOWER)"),
    ("air nozzle", r"(?:AIR|BLOW[\s-]*OFF)[\s-]*(?:NOZZLE|GUN|TOOL)|BLOW[\s-]*GUN"),
)
TOOL_WORDS: Final = AnyCase(
    _LEFT + "(?:" + "|".join(f"(?P<t{i}>{p})" for i, (_, p) in enumerate(TOOL_TYPES)) + ")S?" + _RIGHT
)
FUSION_TOOL: Final = AnyCase(
    rf"^T(?P<n>\d+)\s+D=(?P<d>{_DECIMAL})(?:\s+CR=(?P<cr>{_DECIMAL}))?(?:\s+TAPER=(?P<taper>{_DECIMAL})\s*DEG)?"
    r"(?:\s+-\s+ZMIN=\S+)?(?:\s+-\s+(?P<type>\S.*?)(?:\s+-\s.*)?)?$"
)
MASTERCAM_TOOL: Final = AnyCase(r"^T\s*(?P<n>\d+)\s*\|\s*(?P<name>[^|]*)(?:\||$)")
# "TOOL - 1 DIA. OFF. - 1 LEN. - 1 DIA. - .5", "TOOL NO. - 1", "TOOL 17 - 3/8 EM", "Tool Number: 4"
TOOL_NUMBER: Final = AnyCase(
    r"^TOOL(?:\s*(?:NO\.?|NUM(?:BER|\.)?|#))?\s*[-:=]?\s*(?P<n>\d{1,3})(?![\d./\"]|\s*MM)(?P<rest>.*)$"
)
# "T01 = 80 DEG ROUGH TURNING TOOL"; the letter O for a nought is common.
HAND_TOOL: Final = AnyCase(r"^T(?P<n>O?\d{1,4})(?:\s*[-=:|,]+\s*|\s+)(?P<rest>\S.*)$")
CAMBAM_TOOL: Final = AnyCase(rf"^T(?P<n>\d+)\s+:\s+(?P<d>{_DECIMAL})$")
# One fact each: "DIA: 10", "Tool Diameter = 0.3771 Length = 1.5", "TOOL DIA. 3", "TIP RADIUS: 1"
TOOL_FACT: Final = AnyCase(
    rf"^(?:(?:TOOL\s+DIA(?:M(?:ETER)?|\.)?|DIA(?:METER)?\s*[:=])\s*[:=]?\s*(?P<d>{_DECIMAL})(?!\S)"
    rf"|TIP\s+RADIUS\s*[:=]\s*(?P<cr>{_DECIMAL})(?!\S)"
    r"|TOOL(?:\s+(?:TYPE|NAME))?\s*[:=]\s*(?P<name>[^\d\s].*|\d+/\d+.*))"
)
# Of the tool that is called next: "TC: 6mm Endmill", "Begin operation: TC: 5mm Drill", "tool change to ..."
TOOL_AHEAD: Final = AnyCase(
    r"^(?:(?:BEGIN\s+OPERATION\s*:\s*)?(?:TC|CHANGE\s+TOOL)\s*:|TOOL\s+CHANGE\s+TO\b)\s*(?P<tool>\S.*)"
)
# CopperCAM: 'Tool #1 "Drill 0.8mm" / Diameter 0.8 mm', 'Werkzeug Nr. 1 "Bohrer 0.8mm" / Durchmesser 0.8 mm'
COPPERCAM_TOOL: Final = AnyCase(
    r'^(?:TOOL\s*#|WERKZEUG\s+NR\.?)\s*(?P<n>\d{1,8})\s+"(?P<name>[^"]*)"'
    r"\s*/\s*(?:DIAMETER|DURCHMESSER)\s*(?P<d>\d+(?:[.,]\d*)?|[.,]\d+)\s*(?P<unit>MM\b|IN\b|INCH\b|\")?\s*$"
)
# CutViewer: TOOL/MILL,diameter,corner radius,height,taper and TOOL/DRILL,diameter,point angle,length
CUTVIEWER_TOOL: Final = AnyCase(
    rf"^TOOL/(?:(?P<mill>MILL)|DRILL)\s*,\s*(?P<d>{_DECIMAL})\s*,\s*(?P<second>{_DECIMAL})"
    rf"(?:\s*,\s*(?:{_DECIMAL})(?:\s*,\s*(?P<taper>{_DECIMAL}))?)?\s*$"
)
# A diameter with a unit of its own: 1/2", 3/8 (a bare fraction is inches), 5.75MM.
SIZE: Final = AnyCase(
    rf"(?<![\w./])(?:(?P<mm>{_DECIMAL})\s*MM\b|(?P<frac>{_FRACTION})(?!\s*-\s*\d)(?!\s*AXIS)(?:\s*(?:\"|''|IN\b|INCH\b))?"
    rf"|(?P<inch>{_DECIMAL})\s*(?:\"|''|IN\.?(?=\s|$)|INCH\b))"
)
SAID_DIAMETER: Final = AnyCase(
    rf"(?:\bD(?:IA\w*)?\.?\s*[-=:]\s*|\bDESC:\s*(?=\S+\s+DIA\b)|\bDIA\.\s+(?!\S+\s*-?\s*FL))"
    rf"(?P<d>{_DECIMAL})(?![\w\"/])"
)
SAID_NOSE: Final = AnyCase(
    rf"(?<![\w.])(?:(?P<before>{_DECIMAL})\s*(?:TNR|RAD\b|NOSE\s+RAD)|"
    rf"(?:TNR|(?:NOSE|CORNER|TIP)\s+RADIUS)\s*[:=-]?\s*(?P<after>{_DECIMAL})(?!\w))"
)
# Only a size follows: the comment names the tool ("DRILL 1/4""), not what is done with it.
ONLY_A_SIZE: Final = AnyCase(
    rf"^(?:DRILL|TAP|REAM(?:ER)?|(?:SPOT|CENT(?:ER|RE))\s*DRILL)\s+(?:D|DIA\.?|Ø)?\s*"
    rf"(?:{_FRACTION}|{_DECIMAL})\s*(?:\"|''|MM|IN\.?|DIA\.?)*\s*$"
)
# DRILL, TAP and PROBE are things to do as well: they name a tool behind its size or make, not before work.
WORK_TOO: Final = frozenset({"drill", "spot drill", "center drill", "tap", "counter sink", "probe"})
TOOL_FOR_SURE: Final = AnyCase(
    r"^(?:[\w./\"'#-]*[\d\"'#][\w./\"'°-]*|LET\S*|HSS|CARBIDE|COBALT)\s.*(?:DRILL|TAP|SINK)S?\s*$|\bTWIST\s+DRILL"
)
# Work that is named before the tool that does it: "FINISH WALLS WITH 3/8 E.M.", "POCKET - 1/2 E.M."
_OF_A_TOOL: Final = (
    r"ROUGH\w*|FINISH\w*|LONG|SHORT|STUB\w*|CARBIDE|HSS|COBALT|FLUTES?|FLTS?|FL|BALL|FLAT|BULL|CORNER|NOSE|INSERT\w*"
    r"|INDEX\w*|COATED|NEW|OLD|EXTENDED|REDUCED|CORNCOB|SPOT\w*|CENT\w*|DIA\w*|DEG\w*|RAD\w*|LET\w*|NO|NUM\w*|END"
)
WORK_BEFORE_TOOL: Final = AnyCase(
    rf"^(?:{_PLACE}\s+)*(?:{_any((*_SEMI_FINISH, *_ROUGH, *_FINISH))}\s+)*{_any(_FEATURE)}{_RIGHT}"
    rf"|^(?:{_PLACE}\s+)*{_WORK}\s+(?!(?:{_OF_A_TOOL})\b)[^\W\d_]{{3}}"
)
