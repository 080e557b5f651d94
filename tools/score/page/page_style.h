// Style and script of the score page.
#pragma once

#include <string_view>

namespace touchline::score::page {

inline constexpr std::string_view kStyle = R"css(
:root{--ink:#1c2127;--soft:#68707a;--rule:#e3e6ea;--ground:#f6f7f9;--card:#fff;--accent:#2563c9}
*{box-sizing:border-box}
html{scroll-behavior:smooth}
body{margin:0;font:15px/1.45 system-ui,"Segoe UI",Roboto,"DejaVu Sans",sans-serif;color:var(--ink);background:var(--ground)}
header{padding:26px 32px 8px;background:#17331f;color:#fff}
header h1{margin:0;font-size:26px;font-weight:650}
header p{margin:4px 0 10px;color:#bcd3c3}
nav{position:sticky;top:0;z-index:5;display:flex;gap:4px;padding:6px 24px;background:#17331f;box-shadow:0 1px 4px #0004}
nav a{color:#e8f2eb;text-decoration:none;padding:4px 10px;border-radius:5px}
nav a:hover{background:#ffffff22}
main{max-width:1400px;margin:0 auto;padding:8px 32px 80px}
h2{margin:44px 0 10px;font-size:21px;text-transform:capitalize;scroll-margin-top:52px}
h3{margin:0;font-size:16px}
small,.key,.n{color:var(--soft)}
.key{margin:18px 0 10px}
table{width:100%;border-collapse:collapse;background:var(--card);border:1px solid var(--rule);border-radius:8px;font-variant-numeric:tabular-nums}
th{font-weight:500;text-align:left}
td,th{padding:4px 10px;white-space:nowrap}
td{text-align:right}
td.subject{text-align:left;color:var(--soft)}
thead th{font-size:12px;color:var(--soft);border-bottom:1px solid var(--rule);text-align:right}
thead th:first-child,thead th:nth-child(2){text-align:left}
tbody.group th{padding-top:16px;font-weight:650;text-transform:capitalize}
tbody.group a{color:inherit;text-decoration:none}
tbody.kind tr{border-top:1px solid var(--rule)}
tbody.kind tr.sub{border-top:0;color:#444b54;font-size:13.5px}
tbody.kind tr.head .figure{font-weight:650}
tbody.many tr.head{cursor:pointer}
tbody.many tr.head td.subject::after{content:" \25be";color:var(--accent)}
tbody.many.closed tr.head td.subject::after{content:" \25b8"}
tbody.many.closed tr.sub{display:none}
td.range{color:var(--soft)}
th span{color:var(--soft);display:inline-block;min-width:1.2em}
svg{display:block}
svg.interval{width:138px;height:16px;margin-left:auto}
.interval .rail{stroke:#e3e6ea;stroke-width:2}
.interval .bar{stroke:#8fb0e6;stroke-width:6}
.interval .ideal{stroke:#2b8a3e;stroke-width:2}
.interval circle{fill:var(--accent)}
.charts{display:grid;grid-template-columns:repeat(auto-fill,minmax(520px,1fr));gap:16px}
figure.chart{margin:0;padding:12px 14px 6px;background:var(--card);border:1px solid var(--rule);border-radius:8px}
figcaption{font-weight:600;margin-bottom:4px}
.legend{float:right;font-weight:400;font-size:12.5px;color:var(--soft)}
.legend i{font-style:normal;margin:0 3px 0 9px}
.plot{width:100%;height:auto}
.plot text{font-size:11px;fill:var(--soft)}
.plot .grid{stroke:#e9ecef}
.plot polyline{fill:none;stroke:currentColor;stroke-width:1.5;stroke-linejoin:round}
.plot .oracle{stroke:currentColor;stroke-dasharray:5 4;opacity:.75}
.plot circle{fill:currentColor}
.plot .worst{fill:#fff;stroke:currentColor;stroke-width:2.2}
.plot g.line:hover polyline{stroke-width:3}
.plot:hover g.line:not(:hover){opacity:.3}
.worst h3{display:inline-block}
section.worst{margin:18px 0;padding:14px 16px;background:var(--card);border:1px solid var(--rule);border-radius:8px;scroll-margin-top:52px}
section.worst:target{outline:3px solid #8fb0e6}
section.worst ul{display:inline;margin:0;padding:0;list-style:none}
section.worst li{display:inline-block;margin-left:10px;padding:1px 9px;border-radius:10px;background:#fdecea;color:#8c2b20;font-size:13px}
.shots{display:flex;flex-wrap:wrap;gap:12px;margin-top:10px;align-items:flex-start}
.shot{flex:0 1 calc(50% - 6px);min-width:0}
.shot.wide{flex-basis:100%}
@media(max-width:900px){.shot{flex-basis:100%}}
.shot img{display:block;max-width:100%;height:auto;border-radius:4px}
.shot p{margin:5px 0 0;color:var(--soft);font-size:13px}
.blink{position:relative;cursor:pointer}
.blink .over{position:absolute;inset:0;visibility:hidden}
.blink.on .over{visibility:visible}
.plan{width:100%;max-width:900px;border-radius:6px}
.plan .turf{fill:#2f6b40}
.plan .paint{fill:none;stroke:#ffffff99;stroke-width:.15}
.plan .true{fill:none;stroke:#8df0ab;stroke-width:.28}
.plan .alone{stroke:#ff5a4f}
.plan .told{fill:#ffa53a}
.plan .pair{stroke:#fff;stroke-width:.12}
.none{color:var(--soft);font-style:italic}
.notes li{margin:3px 0}
@media print{nav{position:static}section.worst{break-inside:avoid}}
)css";

// Rows of single subjects fold; pictures change when pressed.
inline constexpr std::string_view kScript = R"js(
document.querySelectorAll('tbody.many').forEach(function(body){
  if(body.rows.length>1)body.classList.add('closed');
  body.rows[0].addEventListener('click',function(){body.classList.toggle('closed')});
});
document.querySelectorAll('.blink').forEach(function(box){
  box.addEventListener('click',function(){
    var on=box.classList.toggle('on');
    box.parentNode.querySelector('.which').textContent=on?'clean':'ours';
  });
});
)js";

}  // namespace touchline::score::page
