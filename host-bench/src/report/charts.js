// One chart for each object of `charts`, by uPlot, in the element `chart-<index>`.
// Charts of one group show the same part of the abscissa.
const groups = {};
let zooming = false;
const digits = (value) => (value == null ? "–" : Number(value.toPrecision(6)).toString());
// The library's own numbers of a logarithmic axis end at a thousandth.
const numbers = (_, values) => values.map((value) => (value == null ? "" : Number(value.toPrecision(4)).toString()));
// "gap [mm]" and a value: "gap: 1.5 mm".
function told(title, value) {
  const [, name, unit] = /^(.*?)(?: \[(.*)\])?$/.exec(title);
  return `${name}: ${digits(value)}${unit ? " " + unit : ""}`;
}
const width = () => Math.min(1120, document.documentElement.clientWidth - 40);

for (const [index, one] of charts.entries()) {
  const distribution = (axis) => (one.logarithmic[axis] ? 3 : 1);
  const sameX = one.curves.every((curve) => curve.x.join() === one.curves[0].x.join());
  const longest = Math.max(0, ...one.curves.flatMap((curve) => curve.bars ?? []));
  const peers = one.group === null ? [] : (groups[one.group] ??= []);
  function zoomed(chart, scale) {
    if (scale !== "x" || zooming) return;
    zooming = true;
    const { min, max } = chart.scales.x;
    for (const other of peers) if (other !== chart) other.setScale("x", { min, max });
    zooming = false;
  }
  // Half the length of each bar above and below its point.
  function bars(chart) {
    const { ctx, bbox } = chart;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    one.curves.forEach((curve, at) => {
      if (!curve.bars || !chart.series[at + 1].show) return;
      ctx.strokeStyle = curve.colour;
      ctx.lineWidth = window.devicePixelRatio;
      ctx.beginPath();
      curve.x.forEach((x, row) => {
        if (curve.y[row] === null) return;
        const left = chart.valToPos(x, "x", true);
        for (const [sign, to] of [[-1, "moveTo"], [1, "lineTo"]]) {
          const end = curve.y[row] + sign * curve.bars[row];
          const isBelow = one.logarithmic[1] && !(end > 0);
          ctx[to](left, isBelow ? bbox.top + bbox.height : chart.valToPos(end, "y", true));
        }
      });
      ctx.stroke();
    });
    ctx.restore();
  }
  const options = {
    title: one.title,
    width: width(),
    height: one.height,
    cursor: {
      ...(one.group === null ? {} : { sync: { key: one.group } }),
      drag: one.group === null ? { x: true, y: true, uni: 30 } : { x: true, y: false },
    },
    legend: { live: sameX },
    scales: {
      x: { time: false, distr: distribution(0) },
      y: {
        distr: distribution(1),
        ...(longest > 0 && !one.logarithmic[1]
          ? { range: (_, low, high) => (low == null ? [0, 1] : uPlot.rangeNum(low - longest, high + longest, 0.1, true)) }
          : {}),
      },
    },
    axes: [
      { label: one.across, ...(one.logarithmic[0] ? { values: numbers } : {}) },
      { label: one.up, size: 72, ...(one.logarithmic[1] ? { values: numbers } : {}) },
    ],
    series: [
      { label: one.across, value: (_, value) => digits(value) },
      ...one.curves.map((curve) => ({
        label: curve.name,
        stroke: curve.colour,
        width: curve.line,
        value: (_, value) => digits(value),
        ...(curve.dashed ? { dash: [7, 5] } : {}),
        ...(curve.line > 0 ? {} : { paths: () => null }),
        points:
          curve.dot > 0
            ? { show: true, size: curve.dot, fill: curve.ring ? "#fff" : curve.colour, width: curve.ring ? 1.6 : 1 }
            : { show: false },
      })),
    ],
    hooks: { setScale: [zoomed], draw: [bars] },
  };
  const place = document.getElementById(`chart-${index}`);
  const chart = new uPlot(options, uPlot.join(one.curves.map((curve) => [curve.x, curve.y])), place);
  peers.push(chart);
  window.addEventListener("resize", () => chart.setSize({ width: width(), height: one.height }));
  // What is known of the nearest point stands beside it.
  const tip = document.createElement("div");
  tip.className = "tip";
  chart.over.append(tip);
  chart.over.addEventListener("mouseleave", () => (tip.style.display = "none"));
  chart.over.addEventListener("mousemove", (event) => {
    const frame = chart.over.getBoundingClientRect();
    const [left, top] = [event.clientX - frame.left, event.clientY - frame.top];
    let nearest = null;
    one.curves.forEach((curve, at) => {
      if (!chart.series[at + 1].show) return;
      curve.x.forEach((x, row) => {
        if (curve.y[row] === null) return;
        const [right, down] = [chart.valToPos(x, "x"), chart.valToPos(curve.y[row], "y")];
        const far = Math.hypot(right - left, down - top);
        if (far < 40 && !(nearest && nearest.far <= far)) nearest = { far, curve, row, right, down };
      });
    });
    tip.style.display = nearest ? "block" : "none";
    if (!nearest) return;
    const { curve, row, right, down } = nearest;
    const bar = curve.bars ? ` ± ${digits(curve.bars[row])}` : "";
    const lines = [told(one.across, curve.x[row]), told(one.up, curve.y[row]) + bar];
    if (curve.named) lines.unshift(curve.name);
    if (curve.notes) lines.push(curve.notes[row]);
    tip.textContent = lines.join("\n");
    tip.style.left = `${right + 12 + tip.offsetWidth > frame.width ? right - 12 - tip.offsetWidth : right + 12}px`;
    tip.style.top = `${Math.max(0, Math.min(down + 12, frame.height - tip.offsetHeight))}px`;
  });
}
