// Dark on light, one column on a telephone, no page break inside a figure on paper.
#include "onboard/mapper/report/report_page.hpp"

namespace kawara::mapper {

const char* const kMapperReportStyle = R"css(
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { font: 14px/1.45 system-ui, sans-serif; margin: 1rem auto; max-width: 1100px; padding: 0 1rem; color: #1d2733; background: #fff; }
h1 { font-size: 1.3rem; margin: 0 0 .2rem; overflow-wrap: anywhere; }
h2 { font-size: 1.05rem; margin: 1.6rem 0 .4rem; border-bottom: 1px solid #dde3ea; }
.sub { color: #556; margin: 0; overflow-wrap: anywhere; }
.warn { border-left: 4px solid #d2691e; background: #fdf3ea; padding: .5rem .8rem; margin: 1rem 0; overflow-wrap: anywhere; }
.warn ul { margin: .2rem 0; padding-left: 1.2rem; }
.tables { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(320px, 100%), 1fr)); gap: 0 2rem; align-items: start; }
.tables > div { min-width: 0; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .2rem .5rem .2rem 0; border-bottom: 1px solid #eef1f4; vertical-align: top; overflow-wrap: anywhere; font-weight: normal; }
thead th { color: #556; border-bottom: 1px solid #c8d0d9; }
.num td, .num thead th + th { text-align: right; }
.num td, .num th { overflow-wrap: normal; white-space: nowrap; }
.wide { overflow-x: auto; }
figure { margin: 0; break-inside: avoid; min-width: 0; }
figure img { display: block; width: 100%; height: auto; border-radius: 3px; }
figcaption { color: #445; font-size: 12px; margin: .2rem 0 .6rem; overflow-wrap: anywhere; }
.pair { display: grid; grid-template-columns: 1fr 1fr; gap: .6rem; max-width: 980px; break-inside: avoid; }
.views { display: grid; grid-template-columns: 1fr 1fr; gap: .8rem; align-items: start; }
.views figure:first-child { grid-column: 1 / -1; }
.bar { border: 1px solid #1d2733; border-top: 0; height: .4em; margin-top: .3rem; }
.scale { display: flex; flex-wrap: wrap; gap: .2rem .9rem; margin: .2rem 0 .7rem; font-size: 12px; color: #445; }
.scale i { display: inline-block; width: 1.1em; height: .9em; margin-right: .3em; vertical-align: -.1em; print-color-adjust: exact; -webkit-print-color-adjust: exact; }
.hists { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(300px, 100%), 1fr)); gap: .8rem; margin: .8rem 0; }
.hist { width: 100%; height: auto; break-inside: avoid; }
.hist rect { fill: #1f6fc4; }
.hist .grid { stroke: #dde3ea; }
.hist text { font-size: 11px; fill: #445; }
.hist .mid { text-anchor: middle; }
.hist .end { text-anchor: end; }
.hist .head { font-weight: bold; fill: #1d2733; }
.note { color: #556; font-size: 12px; max-width: 75em; }
@media (max-width: 500px) { body { margin: .5rem auto; padding: 0 .6rem; } .pair { gap: .3rem; } .views { grid-template-columns: 1fr; } .num { font-size: 12px; } }
@media print { body { max-width: none; margin: 0; } a { color: inherit; } h2 { break-after: avoid; } }
)css";

}  // namespace kawara::mapper
