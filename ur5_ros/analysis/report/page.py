"""The look of the report: style sheet and the script that draws the figures."""

STYLE = """
:root { color-scheme: light dark; --paper: #ffffff; --ink: #1c2127; --soft: #5c6670;
  --line: #d9dee3; --card: #f6f8fa; --good: #1a7f45; --bad: #c0272d; --none: #6b7480; }
@media (prefers-color-scheme: dark) { :root { --paper: #14181d; --ink: #e4e8ec; --soft: #98a2ad;
  --line: #303840; --card: #1c2229; --good: #4cc07c; --bad: #ff7b7b; --none: #98a2ad; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, 'Segoe UI', 'DejaVu Sans', sans-serif; }
main { max-width: 1240px; margin: 0 auto; padding: 20px 16px 60px; }
h1 { font-size: 1.35rem; margin: 0; overflow-wrap: anywhere; }
h2 { font-size: 1.1rem; margin: 34px 0 10px; }
p { margin: 6px 0; }
.soft { color: var(--soft); }
.whole { white-space: nowrap; }
.verdict { display: flex; gap: 16px; align-items: center; border: 1px solid var(--line);
  border-left: 8px solid var(--none); border-radius: 8px; padding: 14px 16px;
  background: var(--card); }
.verdict.pass { border-left-color: var(--good); } .verdict.fail { border-left-color: var(--bad); }
.stamp { font-size: 1.7rem; font-weight: 700; text-transform: uppercase; }
.verdict.unjudged { border-left-color: var(--none); }
.unjudged .stamp { font-size: 1rem; text-transform: none; max-width: 12em; }
.verdict.unjudged .stamp { color: var(--none); }
.pass .stamp, .pill.pass { color: var(--good); } .fail .stamp, .pill.fail { color: var(--bad); }
.pill { font-weight: 600; white-space: nowrap; color: var(--none); }
.about { display: grid; grid-template-columns: repeat(auto-fit, minmax(170px, 1fr));
  gap: 8px 18px; margin: 16px 0 0; }
.about div { min-width: 0; overflow-wrap: anywhere; }
.about div.wide { grid-column: 1 / -1; }
.about span { display: block; color: var(--soft); font-size: 0.8rem; }
table { border-collapse: collapse; width: 100%; }
th { text-align: left; color: var(--soft); font-weight: 500; font-size: 0.8rem; }
th, td { padding: 7px 12px 7px 0; border-bottom: 1px solid var(--line); vertical-align: top; }
td.number { white-space: nowrap; font-variant-numeric: tabular-nums; }
td { overflow-wrap: anywhere; }
td:first-child { min-width: 9em; overflow-wrap: normal; }
.sortable td { overflow-wrap: normal; } .sortable td:first-child { min-width: 0; }
.plots { display: grid; grid-template-columns: 1fr 1fr; gap: 26px 28px; }
figure { margin: 0; min-width: 0; overflow: hidden; } figure.wide { grid-column: 1 / -1; }
figcaption b { display: block; } figcaption { font-size: 0.86rem; color: var(--soft); }
figcaption b { color: var(--ink); font-size: 0.98rem; }
.plot { height: 330px; width: 100%; }
.note { border: 1px dashed var(--line); border-radius: 6px; padding: 10px 12px; }
.js-plotly-plot .plotly:focus-within .modebar--hover { opacity: 1; }
:focus-visible { outline: 2px solid var(--ink); outline-offset: 2px; }
th button { all: unset; cursor: pointer; } th button:focus-visible { outline: 2px solid; }
th[aria-sort=ascending] button::after { content: ' \2191'; }
th[aria-sort=descending] button::after { content: ' \2193'; }
/* made by the script */
.joints { margin: 0 0 12px; font-size: 0.86rem; color: var(--soft); }
.joints button { font: inherit; color: var(--ink); background: var(--card); cursor: pointer;
  border: 1px solid var(--line); border-left: 6px solid var(--joint); border-radius: 6px;
  padding: 2px 10px; margin: 2px 6px 2px 0; }
.joints button[aria-pressed=false] { border-left-color: var(--line); text-decoration: line-through;
  color: var(--soft); }
input[type=search] { font: inherit; color: var(--ink); background: var(--card);
  border: 1px solid var(--line); border-radius: 6px; padding: 4px 8px; margin: 0 0 8px; }
details { border-top: 1px solid var(--line); padding: 8px 0; }
summary { cursor: pointer; } pre { overflow-x: auto; font-size: 0.8rem; }
@media (max-width: 760px) {
  .plots { grid-template-columns: 1fr; } .plot { height: 300px; }
  table:not(.checks) { display: block; overflow-x: auto; }
  .checks thead { display: none; }
  .checks tr { display: grid; grid-template-columns: 1fr auto; gap: 0 10px; padding: 8px 0;
    border-bottom: 1px solid var(--line); }
  .checks td { border: 0; padding: 1px 0; } .checks td:last-child { grid-column: 1 / -1; }
  .checks td.number { font-size: 0.85rem; color: var(--soft); }
  .checks td:nth-child(2), .checks td:nth-child(4) { text-align: right; }
  .checks td.number::before { content: attr(data-label) ' '; }
  .verdict { flex-direction: column; align-items: flex-start; gap: 4px; }
}
"""

SCRIPT = """
'use strict';
const {figures, marks, joints} = JSON.parse(document.getElementById('figures').textContent);
const hidden = new Set();
// where nothing hovers (a phone) the tools would stay
const tools = matchMedia('(hover: none)').matches ? false : 'hover';
// the joint of a curve: its name up to a comma
function jointOf(trace) {
  const name = (trace.name || '').split(',')[0];
  return name in joints ? name : null;
}
function unitOf(title) { return (/\\[([^\\],]+)\\]/.exec(title || '') || ['', ''])[1]; }
function curve(trace, figure) {
  const shown = {visible: hidden.has(jointOf(trace)) ? 'legendonly' : true};
  // "elbow, reference" is the dotted line beside "elbow": the caption says so
  const base = (trace.name || '').split(', ')[0];
  if (base !== trace.name && figure.traces.some((each) => each.name === base)) {
    shown.showlegend = false;
  }
  if (trace.type === 'scatter' && !trace.hovertemplate && unitOf(figure.x)) {
    const unit = unitOf(trace.name) || unitOf(figure.y);
    const name = text((trace.name || '').replace(/ \\[.*\\]/, ''));
    const at = `<br>%{x:.4g} ${unitOf(figure.x)}<extra></extra>`;
    shown.hovertemplate = `${name}: %{y:.4g} ${unit}${at}`;
  }
  return {...trace, ...shown};
}
function look(figure, box) {
  const style = getComputedStyle(document.documentElement);
  const ink = style.getPropertyValue('--ink').trim();
  const line = style.getPropertyValue('--line').trim();
  const narrow = box.clientWidth < 520;
  const axis = {gridcolor: line, zerolinecolor: line, linecolor: line, automargin: true};
  return {
    paper_bgcolor: 'rgba(0,0,0,0)', plot_bgcolor: 'rgba(0,0,0,0)',
    font: {color: ink, size: narrow ? 10 : 12, family: 'system-ui, DejaVu Sans, sans-serif'},
    margin: {l: narrow ? 48 : 62, r: 10, t: 34, b: 44},  // the tools stand above the plot
    xaxis: {...axis, title: {text: figure.x, standoff: 6},
      type: (figure.category || '').includes('x') ? 'category' : undefined, ...figure.xaxis},
    yaxis: {...axis, title: {text: figure.y, standoff: 6},
      scaleanchor: figure.equal ? 'x' : undefined,
      type: (figure.category || '').includes('y') ? 'category' : figure.log ? 'log' : 'linear',
      exponentformat: 'power', minorloglabels: 'none',
      nticks: (figure.category || '').includes('y') ? 99 : narrow ? 6 : 8, ...figure.yaxis},
    width: box.clientWidth, height: box.clientHeight,
    modebar: {bgcolor: 'rgba(0,0,0,0)', color: line, activecolor: ink},
    legend: {orientation: 'h', x: 0, font: {size: narrow ? 9 : 11},
      ...(figure.legend === 'above' ? {y: 1.02, yanchor: 'bottom'} : {y: -0.2})},
    hovermode: 'closest', dragmode: narrow ? false : 'zoom', bargap: 0,
    hoverlabel: {namelength: -1},
    shapes: figure.x !== 'time [s]' ? [] : marks.map((mark) => ({type: 'line', xref: 'x',
      yref: 'paper', x0: mark.t, x1: mark.t, y0: 0, y1: 1,
      line: {color: ink, width: 1, dash: 'dot'}})),
    annotations: figure.x !== 'time [s]' ? [] : marks.map((mark) => ({xref: 'x', yref: 'paper',
      x: mark.t, y: 1, text: text(mark.text), textangle: -90, showarrow: false,
      xanchor: 'left', yanchor: 'top', font: {size: 9, color: ink}})),
  };
}
// Plotly takes some markup in texts
function text(words) {
  return words.replaceAll('&', '&amp;').replaceAll('<', '&lt;').replaceAll('>', '&gt;');
}
function draw() {
  for (const figure of figures) {
    const box = document.getElementById('plot-' + figure.key);
    Plotly.react(box, figure.traces.map((trace) => curve(trace, figure)), look(figure, box),
      {displaylogo: false, displayModeBar: tools, showSendToCloud: false,
        modeBarButtonsToRemove: ['lasso2d', 'select2d']});
  }
}
// a joint is shown or hidden in all figures alike, by a button or by the legend
function select(joint, only) {
  const others = Object.keys(joints).filter((name) => name !== joint);
  if (!only) {
    if (!hidden.delete(joint)) hidden.add(joint);
  } else if (!hidden.has(joint) && others.every((name) => hidden.has(name))) {
    hidden.clear();
  } else {
    hidden.delete(joint);
    others.forEach((name) => hidden.add(name));
  }
  for (const button of document.querySelectorAll('.joints button')) {
    button.setAttribute('aria-pressed', String(!hidden.has(button.dataset.joint)));
  }
  if (window.Plotly) draw();
}
function connect() {
  draw();
  for (const figure of figures) {
    const box = document.getElementById('plot-' + figure.key);
    for (const [click, only] of [['', false], ['double', true]]) {
      box.on(`plotly_legend${click}click`, (event) => {
        const joint = jointOf(event.data[event.curveNumber]);
        if (joint) select(joint, only);
        return !joint;
      });
    }
  }
}
const first = document.querySelector('.plots');
const used = Object.keys(joints).filter((name) => figures.some(
  (figure) => figure.traces.some((trace) => jointOf(trace) === name)));
if (first && used.length > 1) {
  const bar = document.createElement('div');
  bar.className = 'joints';
  bar.append('joints in the figures: ');
  for (const name of used) {
    const button = document.createElement('button');
    button.dataset.joint = name;
    button.setAttribute('aria-pressed', 'true');
    button.style.setProperty('--joint', joints[name]);
    button.textContent = name;
    button.addEventListener('click', () => select(name, false));
    bar.append(button);
  }
  first.before(bar);
}
async function unpack() {
  const packed = atob(document.getElementById('library').textContent);
  const bytes = Uint8Array.from(packed, (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  const program = new Blob([await new Response(stream).blob()], {type: 'text/javascript'});
  const script = document.createElement('script');
  script.src = URL.createObjectURL(program);
  script.onload = connect;
  document.head.append(script);
}
unpack();
// a table that can be sorted by its headers and filtered by words
for (const table of document.querySelectorAll('table.sortable')) {
  const body = table.tBodies[0];
  const field = document.createElement('input');
  field.type = 'search';
  field.placeholder = 'filter rows';
  field.setAttribute('aria-label', 'filter rows');
  field.addEventListener('input', () => {
    const words = field.value.toLowerCase();
    for (const row of body.rows) row.hidden = !row.textContent.toLowerCase().includes(words);
  });
  table.before(field);
  [...table.tHead.rows[0].cells].forEach((head, column) => {
    const button = document.createElement('button');
    button.textContent = head.textContent;
    head.replaceChildren(button);
    button.addEventListener('click', () => {
      const down = head.getAttribute('aria-sort') === 'ascending';
      for (const other of table.tHead.rows[0].cells) other.removeAttribute('aria-sort');
      head.setAttribute('aria-sort', down ? 'descending' : 'ascending');
      const key = (row) => row.cells[column].textContent;
      const order = [...body.rows].sort((a, b) => key(a).localeCompare(
        key(b), undefined, {numeric: true}) * (down ? -1 : 1));
      body.append(...order);
    });
  });
}
let waiting = 0;
const again = () => { if (window.Plotly) draw(); };
addEventListener('resize', () => { clearTimeout(waiting); waiting = setTimeout(again, 120); });
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', again);
"""
