// One chart for each object of `charts`, by uPlot, in the element `chart-<index>`.
// Charts of one group show the same part of the abscissa.
const groups = {};
let zooming = false;
const digits = (value) => (value == null ? "–" : Number(value.toPrecision(6)).toString());
// A number as a power of ten, with a factor unless that is 1.
function power(value) {
  const [factor, exponent] = value.toExponential().split("e");
  const digits = [...String(Number(exponent))].map((digit) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(digit)]);
  return `${factor}·10${digits.join("")}`.replace(/^(-?)1·/, "$1");
}
// Numbers at the ticks in one notation, as an SVG has them: the library's own end at a thousandth.
const numbers = (isLogarithmic) => (_, values) => {
  const present = values.filter((value) => value != null);
  const closest = Math.min(...present.slice(1).map((value, index) => Math.abs(value - present[index])));
  const largest = Math.max(...values.map((value) => Math.abs(value ?? 0)));
  const hasPowers = isLogarithmic && present.every((value) => value.toExponential().startsWith("1e"));
  const isPlain = !hasPowers && largest >= 0.01 && largest < 1e5;
  // As many digits as tell the closest two ticks apart.
  const places = Math.min(15, Math.max(6, Math.ceil(Math.log10(largest / closest)) + 1) || 6);
  const text = (value) => (isPlain ? value.toString() : power(value));
  return values.map((value) => (value == null ? "" : value === 0 ? "0" : text(Number(value.toPrecision(places)))));
};
// The ticks of a logarithmic axis: decades, with 2 and 5 where there are few, and even distances where there are fewer.
function decades(_, axis, min, max) {
  const [low, high] = [Math.floor(Math.log10(min)), Math.ceil(Math.log10(max))];
  const parts = high - low > 4 ? [1] : [1, 2, 5];
  const every = Math.max(1, Math.ceil((high - low) / 10));
  const ticks = [];
  for (let decade = low; decade <= high; decade += every)
    for (const part of parts) ticks.push(Number(`${part}e${decade}`));
  const within = ticks.filter((tick) => tick >= min * (1 - 1e-9) && tick <= max * (1 + 1e-9));
  if (within.length > 2) return within;
  const step = Number(((max - min) / 4).toPrecision(1));
  const even = [];
  for (let tick = Math.ceil(min / step); tick * step <= max; tick += 1) even.push(Number((tick * step).toPrecision(12)));
  return even;
}
const scaled = (isLogarithmic) => ({
  values: numbers(isLogarithmic),
  ...(isLogarithmic ? { splits: decades, filter: (_, ticks) => ticks } : {}),
});
// "gap [mm]" and a value: "gap: 1.5 mm".
function readout(title, value) {
  const [, name, unit] = /^(.*?)(?: \[(.*)\])?$/.exec(title);
  return `${name}: ${digits(value)}${unit ? " " + unit : ""}`;
}
// The number at a place between the edges, on the line between two.
function between(edges, numbers, place) {
  const last = edges.length - 1;
  const next = Math.max(1, Math.min(last, edges.findIndex((edge) => edge > place)));
  const below = place >= edges[last] ? last - 1 : next - 1;
  const part = (place - edges[below]) / (edges[below + 1] - edges[below]);
  return numbers[below] + part * (numbers[below + 1] - numbers[below]);
}
// The cell at a place, and what is known of it; null beside the field.
function cell(field, x, y) {
  const [column, row] = [[field.x, x], [field.y, y]].map(([edges, place]) =>
    place < edges[0] ? -1 : edges.findIndex((edge) => edge > place) - 1,
  );
  if (column < 0 || row < 0) return null;
  const index = row * (field.x.length - 1) + column;
  const lines = field.readouts.map(({ of, title, values, texts }) => {
    const value = values[{ column, row, cell: index }[of]];
    return texts ? texts[value] : readout(title, value);
  });
  return lines.join("\n");
}
const dashes = ({ dash }) => (dash?.split(" ") ?? []).map(Number);
const width = () => Math.min(1120, document.documentElement.clientWidth - 40);

for (const [index, one] of charts.entries()) {
  const distribution = (axis) => (one.logarithmic[axis] ? 3 : 1);
  const { field, span } = one;
  const sameX = !span && one.curves.every((curve) => curve.x.join() === one.curves[0].x.join());
  const longest = Math.max(0, ...one.curves.flatMap((curve) => curve.bars ?? []));
  const peers = one.group === null ? [] : (groups[one.group] ??= []);
  function zoomed(chart, scale) {
    if (scale !== "x" || zooming) return;
    zooming = true;
    const { min, max } = chart.scales.x;
    for (const other of peers) if (other !== chart) other.setScale("x", { min, max });
    zooming = false;
  }
  // A chart with a span of its own has a first series without a mark, from corner to corner of it.
  const first = span ? 2 : 1;
  const number = (x) => (field?.numbers ? between(field.x, field.numbers, x) : x);
  function clipped(chart, paint) {
    const { ctx, bbox } = chart;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    paint(ctx, bbox);
    ctx.restore();
  }
  const cells = (chart) => clipped(chart, (ctx) => {
    const left = field.x.map((x) => Math.round(chart.valToPos(x, "x", true)));
    const low = field.y.map((y) => Math.round(chart.valToPos(y, "y", true)));
    field.shades.forEach((shade, index) => {
      if (shade === null) return;
      const [column, row] = [index % (left.length - 1), Math.floor(index / (left.length - 1))];
      ctx.fillStyle = field.palette[shade];
      ctx.fillRect(left[column], low[row + 1], left[column + 1] - left[column], low[row] - low[row + 1]);
    });
  });
  // With an edge a line is seen on each colour of the cells.
  const strokes = (edge) => (chart) => clipped(chart, (ctx) => {
    one.curves.forEach((curve, at) => {
      if (!chart.series[at + first].show || !curve.line) return;
      ctx.strokeStyle = edge ? "#fff" : curve.colour;
      ctx.lineWidth = (curve.line + edge) * window.devicePixelRatio;
      ctx.lineJoin = "round";
      ctx.setLineDash(edge ? [] : dashes(curve).map((length) => length * window.devicePixelRatio));
      ctx.beginPath();
      let isOn = false;
      curve.x.forEach((x, row) => {
        const y = curve.y[row];
        const isPoint = x !== null && y !== null;
        if (isPoint) ctx[isOn ? "lineTo" : "moveTo"](chart.valToPos(x, "x", true), chart.valToPos(y, "y", true));
        isOn = isPoint;
      });
      ctx.stroke();
    });
  });
  // The polygon of a sign around each point.
  const signs = ({ sign, dot }) => (chart, series, from, to) => {
    const [stroke, half] = [new Path2D(), 0.45 * dot * window.devicePixelRatio];
    for (let row = from; row <= to; row += 1) {
      const [x, y] = [chart.data[0][row], chart.data[series][row]];
      const [left, top] = [chart.valToPos(x, "x", true), chart.valToPos(y, "y", true)];
      if (y != null) sign.forEach(([right, down], at) => stroke[at ? "lineTo" : "moveTo"](left + half * right, top + half * down));
    }
    return { stroke, fill: stroke, flags: 3 };
  };
  // Half the length of each bar above and below its point.
  const bars = (chart) => clipped(chart, (ctx, bbox) => {
    one.curves.forEach((curve, at) => {
      if (!curve.bars || !chart.series[at + first].show) return;
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
  });
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
      x: {
        time: false,
        distr: distribution(0),
        // By itself it would go to the next power of ten.
        ...(one.logarithmic[0] ? { range: (_, low, high) => [low, high] } : {}),
      },
      y: {
        distr: distribution(1),
        ...(span ? { range: () => span[1] } : {}),
        ...(longest > 0 && !span && !one.logarithmic[1]
          ? { range: (_, low, high) => (low == null ? [0, 1] : uPlot.rangeNum(low - longest, high + longest, 0.1, true)) }
          : {}),
      },
    },
    axes: [
      {
        label: one.across,
        grid: { show: !field },
        ...scaled(one.logarithmic[0]),
        ...(field?.numbers
          ? { values: (_, places) => places.map((x) => (x < 0 || x > 1 ? "" : Number(number(x).toPrecision(5)).toString())) }
          : {}),
      },
      { label: one.up, size: 72, grid: { show: !field }, ...scaled(one.logarithmic[1]) },
    ],
    series: [
      { label: one.across, value: (_, value) => digits(value) },
      ...(span ? [{ class: "frame", paths: () => null, points: { show: false } }] : []),
      ...one.curves.map((curve) => ({
        label: curve.name,
        show: !curve.hidden,
        stroke: curve.colour,
        width: curve.line,
        value: (_, value) => digits(value),
        dash: dashes(curve),
        ...(curve.line > 0 ? {} : { paths: () => null }),
        // On cells a dot has a light edge.
        points:
          curve.dot > 0
            ? { show: true, size: curve.dot + (field ? 2 : 0), width: curve.filled && !curve.sign ? 1 : 1.6, ...(curve.sign && { paths: signs(curve) }),
                stroke: field && curve.filled ? "#fff" : curve.colour, fill: curve.filled ? curve.colour : "#fff" }
            : { show: false },
      })),
    ],
    hooks: { setScale: [zoomed], drawClear: field ? [cells, strokes(2)] : [], draw: one.orbits ? [strokes(0)] : [bars] },
  };
  const place = document.getElementById(`chart-${index}`);
  const tables = one.curves.map((curve) => (one.orbits ? [span[0], [null, null]] : [curve.x, curve.y]));
  const chart = new uPlot(options, uPlot.join(span ? [span, ...tables] : tables), place);
  peers.push(chart);
  window.addEventListener("resize", () => chart.setSize({ width: width(), height: one.height }));
  place.setAttribute("aria-label", one.words);
  place.setAttribute("role", "group");
  // By the keyboard: arrows move along the abscissa, + and - zoom, Escape shows all, Enter on a name hides its curve.
  const moves = { ArrowLeft: [-0.25, 0.75], ArrowRight: [0.25, 1.25], "+": [0.25, 0.75], "-": [-0.5, 1.5] };
  chart.over.tabIndex = 0;
  chart.over.addEventListener("keydown", (event) => {
    const { key } = event;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (key === "Escape") chart.setData(chart.data);
    if (!(key in moves)) return;
    event.preventDefault();
    const [min, max] = moves[key].map((part) => chart.posToVal(part * chart.over.clientWidth, "x"));
    chart.setScale("x", { min, max });
  });
  // The mark before a name is that of its curve: its line with dashes, and its sign.
  const rows = [...place.querySelectorAll(".u-series")].slice(-one.curves.length);
  one.curves.forEach(({ line, dash, dot, filled, sign, colour }, at) => {
    const look = `fill="${filled ? colour : "#fff"}" stroke="${colour}" vector-effect="non-scaling-stroke" stroke-width="1.6"`;
    const shape = sign ? `<polyline points="${sign}" ${look}/>` : `<circle r="1" ${look}/>`;
    const sample = `<svg xmlns="http://www.w3.org/2000/svg" width="36" height="16"><g transform="translate(0 8)">
      <path d="M0 0H36" stroke="${colour}" stroke-width="${line}" stroke-dasharray="${dash ?? ""}"/>
      ${dot > 0 ? `<g transform="translate(18) scale(${0.45 * dot})">${shape}</g>` : ""}</g></svg>`;
    Object.assign(rows[at].querySelector(".u-marker").style, { width: "36px", height: "16px", border: 0, background: `url("data:image/svg+xml,${encodeURIComponent(sample)}")` });
  });
  // A live legend has a row for the abscissa, which hides nothing.
  for (const name of [...place.querySelectorAll(".u-series th")].slice(sameX ? 1 : 0)) {
    name.tabIndex = 0;
    name.addEventListener("keydown", ({ key }) => key === "Enter" && name.click());
  }
  // What is known of the nearest point stands beside it.
  const tip = document.createElement("div");
  tip.className = "tip";
  chart.over.append(tip);
  chart.over.addEventListener("mouseleave", () => (tip.style.display = "none"));
  chart.over.addEventListener("mousemove", (event) => {
    const frame = chart.over.getBoundingClientRect();
    const [left, top] = [event.clientX - frame.left, event.clientY - frame.top];
    // Of points at one place that which is drawn above the others.
    let nearest = null;
    one.curves.forEach((curve, at) => {
      if (!chart.series[at + first].show) return;
      curve.x.forEach((x, row) => {
        if (x === null || curve.y[row] === null) return;
        const [right, down] = [chart.valToPos(x, "x"), chart.valToPos(curve.y[row], "y")];
        const far = Math.hypot(right - left, down - top);
        if (far < (field ? 8 : 40) && !(nearest && nearest.far < far)) nearest = { far, curve, row, right, down };
      });
    });
    const below = field && !nearest ? cell(field, chart.posToVal(left, "x"), chart.posToVal(top, "y")) : null;
    tip.style.display = nearest || below ? "block" : "none";
    if (!nearest && !below) return;
    const [right, down] = nearest ? [nearest.right, nearest.down] : [left, top];
    tip.textContent = below;
    if (nearest) {
      const { curve, row } = nearest;
      const bar = curve.bars ? ` ± ${digits(curve.bars[row])}` : "";
      const lines = [readout(one.across, number(curve.x[row])), readout(one.up, curve.y[row]) + bar];
      if (curve.named) lines.unshift(curve.name);
      if (curve.notes) lines.push(curve.notes[row]);
      tip.textContent = lines.join("\n");
    }
    tip.style.left = `${right + 12 + tip.offsetWidth > frame.width ? right - 12 - tip.offsetWidth : right + 12}px`;
    tip.style.top = `${Math.max(0, Math.min(down + 12, frame.height - tip.offsetHeight))}px`;
  });
}
