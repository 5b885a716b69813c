// Pictures of numbers: throughput over time, colours of tile times, words for quantities.

/** From dark blue (0) over red to pale yellow (1), as the legend shows it. */
export function heatColour(share) {
  const stops = [[27, 42, 99], [106, 44, 145], [199, 62, 107], [245, 141, 60], [251, 233, 138]];
  const at = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
  const low = Math.min(Math.floor(at), stops.length - 2);
  return stops[low].map((value, i) => Math.round(value + (stops[low + 1][i] - value) * (at - low)));
}

export function seconds(value) {
  if (value == null || !isFinite(value)) return '–';
  if (value < 0.001) return `${Math.round(value * 1e6)} µs`;
  if (value < 1) return `${(value * 1e3).toPrecision(3)} ms`;
  if (value < 100) return `${value.toPrecision(3)} s`;
  if (value < 3600) return `${Math.floor(value / 60)} min ${Math.round(value % 60)} s`;
  return `${Math.floor(value / 3600)} h ${Math.round(value % 3600 / 60)} min`;
}

export function rate(value) {
  return value >= 100 ? Math.round(value).toLocaleString('en') : value >= 10 ? value.toFixed(1) : value.toFixed(2);
}

export function bytes(value) {
  const units = ['B', 'kB', 'MB', 'GB', 'TB'];
  let unit = 0;
  while (value >= 1000 && unit < units.length - 1) { value /= 1000; unit++; }
  return `${unit === 0 ? value : value.toPrecision(3)} ${units[unit]}`;
}

/** Steps of throughput as bars; the last one is not over and drawn pale. */
export function drawThroughput(canvas, data) {
  const scale = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  canvas.width = width * scale;
  canvas.height = height * scale;
  const draw = canvas.getContext('2d');
  draw.scale(scale, scale);
  const style = getComputedStyle(document.documentElement);
  const top = Math.max(...data.tiles, 1);
  const step = width / data.tiles.length;
  draw.fillStyle = style.getPropertyValue('--line');
  draw.fillRect(0, height - 1, width, 1);
  draw.fillStyle = style.getPropertyValue('--accent');
  data.tiles.forEach((tiles, i) => {
    draw.globalAlpha = i === data.tiles.length - 1 ? 0.4 : 1;
    const size = tiles / top * (height - 4);
    if (tiles > 0) draw.fillRect(i * step + 0.5, height - Math.max(size, 2), Math.max(step - 1, 1), Math.max(size, 2));
  });
  draw.globalAlpha = 1;
  return top / data.step_seconds;
}
