"""How a comparison is shown: as a patch, side by side, as a page, as JSON.

What cannot be printed is escaped: a program's text and its name give no orders to a terminal or a browser.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from typing import Any

from chipbreak.editing.diff import Hunk, Item, differs
from chipbreak.text.encoding import escaped

_CONTEXT = 3
# What stands in both programs, only in the first, or only in the second.
_Pair = tuple[Item | None, Item | None]
_Row = tuple[str, Item | None, Item | None]
_LEAST_WIDTH = 20
_SKIPPED = "..."


def unified(hunks: Sequence[Hunk], name_a: str, name_b: str) -> Iterator[str]:
    """The changes with their surroundings, as ``diff -u`` writes them."""
    if not differs(hunks):
        return
    yield f"--- {escaped(name_a)}"
    yield f"+++ {escaped(name_b)}"
    group: list[_Pair] = []
    for index, hunk in enumerate(hunks):
        if hunk.tag == "change":
            group += [(item, None) for item in hunk.a_items] + [(None, item) for item in hunk.b_items]
            continue
        pairs: list[_Pair] = list(zip(hunk.a_items, hunk.b_items, strict=True))
        is_last = index == len(hunks) - 1
        if group and (is_last or len(pairs) > 2 * _CONTEXT):
            yield from _print_group(group + pairs[:_CONTEXT])
            group = []
        if not group and not is_last:
            group = pairs[-_CONTEXT:]
        elif not is_last:
            group += pairs
    if any(None in pair for pair in group):
        yield from _print_group(group)


def _print_group(group: Sequence[_Pair]) -> Iterator[str]:
    a = [item.line for item, _ in group if item is not None]
    b = [item.line for _, item in group if item is not None]
    yield f"@@ -{a[0] if a else 0},{len(a)} +{b[0] if b else 0},{len(b)} @@"
    for one, other in group:
        if one is not None:
            yield (" " if other is not None else "-") + _shown(one)
        elif other is not None:
            yield "+" + _shown(other)


def _shown(item: Item) -> str:
    text = _text(item)
    return f"{text}  [{item.note}]" if item.note else text


def _text(item: Item) -> str:
    """The block on one line; a tab is a blank."""
    return escaped(item.text.replace("\t", " "))


def as_json(hunks: Sequence[Hunk]) -> list[dict[str, Any]]:
    """The changes for a program to read."""

    def side(items: Sequence[Item]) -> list[dict[str, Any]]:
        return [
            {"line": item.line, "text": item.text} | ({"note": item.note} if item.note else {})
            for item in items
        ]

    return [{"a": side(h.a_items), "b": side(h.b_items)} for h in hunks if h.tag == "change"]


def _rows(hunks: Sequence[Hunk]) -> Iterator[_Row]:
    """Rows of two columns: ``=`` equal, ``|`` changed, ``<`` and ``>`` only there, ``.`` left out."""
    for index, hunk in enumerate(hunks):
        if hunk.tag == "equal":
            yield from _equal_rows(hunk, is_first=index == 0, is_last=index == len(hunks) - 1)
            continue
        shared = min(len(hunk.a_items), len(hunk.b_items))
        for one, other in zip(hunk.a_items, hunk.b_items, strict=False):
            yield "|", one, other
        for one in hunk.a_items[shared:]:
            yield "<", one, None
        for other in hunk.b_items[shared:]:
            yield ">", None, other


def _equal_rows(hunk: Hunk, *, is_first: bool, is_last: bool) -> Iterator[_Row]:
    """The blocks around changes; what lies between is one row."""
    pairs = list(zip(hunk.a_items, hunk.b_items, strict=True))
    head = 0 if is_first else _CONTEXT
    tail = 0 if is_last else _CONTEXT
    if len(pairs) <= head + tail + 1:
        yield from (("=", *pair) for pair in pairs)
        return
    yield from (("=", *pair) for pair in pairs[:head])
    yield ".", None, None
    yield from (("=", *pair) for pair in pairs[len(pairs) - tail :])


def side_by_side(hunks: Sequence[Hunk], name_a: str, name_b: str, width: int) -> Iterator[str]:
    """Both programs beside each other in ``width`` characters; empty when nothing is changed."""
    if not differs(hunks):
        return
    half = max((width - 19) // 2, _LEAST_WIDTH)
    yield f"{'':6} {escaped(name_a)[:half]:{half}}   {'':6} {escaped(name_b)[:half]}".rstrip()
    for sign, one, other in _rows(hunks):
        if sign == ".":
            yield _SKIPPED
            continue
        left = f"{one.line:6} {_shown(one)[:half]:{half}}" if one else f"{'':6} {'':{half}}"
        right = f"{other.line:6} {_shown(other)[:half]}" if other else ""
        yield f"{left} {' ' if sign == '=' else sign} {right}".rstrip()


_PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
body {{ font: 14px/1.4 system-ui, sans-serif; margin: 1.5em; color: #111; background: #fff }}
h1 {{ font-size: 1.4em; overflow-wrap: anywhere }}
table {{ border-collapse: collapse; width: 100%; table-layout: fixed }}
td, th {{ font: 13px/1.4 ui-monospace, monospace; padding: 1px 6px; text-align: left; vertical-align: top;
 white-space: pre-wrap; overflow-wrap: anywhere }}
td.n {{ width: 4.5em; color: #555; text-align: right }}
td.s, th.s {{ padding: 1px 0; text-align: center; font-weight: bold }}
col.n {{ width: 5em }}
col.s {{ width: 1.4em }}
tr.change td {{ background: #fff1d6 }}
tr.only-a td.a {{ background: #f9dcd2 }}
tr.only-b td.b {{ background: #d5e8f7 }}
tr.skipped td {{ color: #777; text-align: center }}
.note {{ color: #7a3e00; font-style: italic }}
@media screen and (max-width: 40em) {{
 body {{ margin: .6em }} td, th {{ font-size: 11.5px; padding: 1px 3px }}
 col.n {{ width: 3em }} col.s {{ width: 1em }} }}
@media print {{ body {{ margin: 0 }} tr {{ break-inside: avoid }} }}
</style></head><body>
<h1>{title}</h1><p>{summary}</p>
<table><colgroup><col class="n"><col><col class="s"><col class="n"><col></colgroup>
<thead><tr><th></th><th>{a}</th><th class="s"></th><th></th><th>{b}</th></tr></thead><tbody>
{rows}
</tbody></table></body></html>
"""
_CLASSES = {"=": "same", "|": "change", "<": "only-a", ">": "only-b"}


def page(hunks: Sequence[Hunk], name_a: str, name_b: str) -> str:
    """The comparison as one HTML page that needs nothing else."""
    changes = sum(hunk.tag == "change" for hunk in hunks)
    summary = f"{changes} place{'s' if changes != 1 else ''} differ{'s' if changes == 1 else ''}."
    rows = "\n".join(_html_row(*row) for row in _rows(hunks)) if changes else ""
    shown_a, shown_b = escape(escaped(name_a)), escape(escaped(name_b))
    title = f"{shown_a} and {shown_b}"
    return _PAGE.format(
        title=title,
        summary=summary if changes else "Both programs say the same.",
        a=shown_a,
        b=shown_b,
        rows=rows,
    )


def _html_row(sign: str, one: Item | None, other: Item | None) -> str:
    if sign == ".":
        return f'<tr class="skipped"><td colspan="5">{_SKIPPED}</td></tr>'
    # The sign says what the colour says: on paper, and to eyes that do not tell the colours apart.
    between = f'<td class="s">{"" if sign == "=" else escape(sign)}</td>'
    return f'<tr class="{_CLASSES[sign]}">{_cells(one, "a")}{between}{_cells(other, "b")}</tr>'


def _cells(item: Item | None, side: str) -> str:
    if item is None:
        return f'<td class="n {side}"></td><td class="{side}"></td>'
    note = f' <span class="note">{escape(item.note)}</span>' if item.note else ""
    return f'<td class="n {side}">{item.line}</td><td class="{side}">{escape(_text(item))}{note}</td>'
