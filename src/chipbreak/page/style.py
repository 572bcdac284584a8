"""How the page looks, on a screen and on paper."""

from __future__ import annotations

STYLE = """
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, "DejaVu Sans", sans-serif; color: #202124; background: #fff; margin: 0; }
main { max-width: 66rem; margin: 2rem auto; padding: 0 1.2rem; }
h1 { font-size: 1.6rem; margin: 0 0 .3rem; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; margin: 2rem 0 .5rem; border-bottom: 1px solid #d8dce0; padding-bottom: .2rem; }
.lead { font-size: 1.1rem; margin: .2rem 0; }
.about { color: #5f6368; }
table { border-collapse: collapse; width: 100%; font-size: .9rem; }
th, td { text-align: left; padding: .25rem .6rem .25rem 0; vertical-align: top; }
tr { border-bottom: 1px solid #e8eaed; }
th { font-weight: 600; vertical-align: bottom; }
td { font-variant-numeric: tabular-nums; }
td:first-child { white-space: nowrap; }
.wide { overflow-x: auto; }
pre { background: #f1f3f4; padding: .5rem .7rem; overflow-x: auto; white-space: pre-wrap; }
figure { margin: .6rem 0 1.2rem; }
figure svg { width: 100%; height: auto; max-width: 54rem; }
figcaption { color: #5f6368; font-size: .9rem; max-width: 50rem; }
li.error b { color: #b3261e; } li.warning b { color: #8a4b00; }
@media screen and (max-width: 40rem) {
  figure { overflow-x: auto; } figure svg { min-width: 36rem; } .lead { font-size: 1rem; }
}
@page { margin: 14mm 12mm; }
@media print {
  body { font-size: 10.5pt; } main { margin: 0; max-width: none; padding: 0; }
  .wide { overflow: visible; } .wide table { font-size: 7.6pt; } th, td { padding-right: .3rem; }
  section.cut { break-before: page; } figure, tr, li { break-inside: avoid; } h2 { break-after: avoid; }
}
"""
