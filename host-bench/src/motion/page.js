// One chart for each object of `charts`, by uPlot.
const place = document.getElementById("charts");
const inTime = [];
let zooming = false;
// Time histories show the same part of the time.
function zoomed(chart, scale) {
  if (scale !== "x" || zooming || !inTime.includes(chart)) return;
  zooming = true;
  const { min, max } = chart.scales.x;
  for (const other of inTime) if (other !== chart) other.setScale("x", { min, max });
  zooming = false;
}
const digits = (_, value) => (value == null ? "–" : Number(value.toPrecision(6)).toString());
// The library's own numbers of a logarithmic axis end at a thousandth.
const numbers = (_, values) => values.map((value) => (value == null ? "" : Number(value.toPrecision(4)).toString()));
for (const one of charts) {
  const distribution = (index) => (one.logarithmic[index] ? 3 : 1);
  const options = {
    width: Math.min(1120, document.documentElement.clientWidth - 40),
    height: one.inTime ? 230 : 380,
    cursor: one.inTime ? { sync: { key: "time" } } : {},
    scales: { x: { time: false, distr: distribution(0) }, y: { distr: distribution(1) } },
    axes: [
      { label: one.across, ...(one.logarithmic[0] ? { values: numbers } : {}) },
      { label: one.up, size: 72, ...(one.logarithmic[1] ? { values: numbers } : {}) },
    ],
    series: [
      { label: one.across, value: digits },
      ...one.curves.map((curve) => ({
        label: curve.name,
        stroke: curve.colour,
        width: 1.4,
        value: digits,
        ...(curve.dots
          ? { paths: () => null, points: { show: true, size: 7, fill: curve.colour } }
          : { points: { show: false } }),
      })),
    ],
    hooks: { setScale: [zoomed] },
  };
  const chart = new uPlot(options, uPlot.join(one.curves.map((curve) => [curve.x, curve.y])), place);
  if (one.inTime) inTime.push(chart);
}
