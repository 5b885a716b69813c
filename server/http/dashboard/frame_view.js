// One frame: its picture, which fills tile by tile, and the map of its tile times.
import {ask} from './live.js';
import {heatColour, seconds} from './charts.js';

const kTile = 32;
const kStrip = 128;  // Tiles of one request.
const kReach = 4;  // Tiles: how far a tile of a frame that is rendered coarse to fine stands for others.

const onePixel = new OffscreenCanvas(1, 1).getContext('2d', {willReadFrequently: true});
onePixel.imageSmoothingQuality = 'high';

/** The mean of a part of a strip of tiles. */
function meanColour(strip, top, width, height) {
  onePixel.clearRect(0, 0, 1, 1);
  onePixel.drawImage(strip, 0, top, width, height, 0, 0, 1, 1);
  const [red, green, blue] = onePixel.getImageData(0, 0, 1, 1).data;
  return `rgb(${red} ${green} ${blue})`;
}

export class FrameView {
  constructor(elements) {
    Object.assign(this, elements);  // picture, overlay, state, legend, low, high
    this.run = 0;
  }

  /** Shows a frame of a job, from an empty picture on. */
  show(job, frame) {
    this.run++;
    Object.assign(this, {job, frame, cursor: '', times: new Map(), wanted: new Set(), drawn: new Set(),
                         standIns: new Map(), busy: false, again: false, finished: false, shown: false});
    for (const canvas of [this.picture, this.overlay]) {
      canvas.width = job.width;
      canvas.height = job.height;
      canvas.classList.toggle('pixelated', job.width < 480);
    }
    // Small frames are enlarged, so that tiles can be told apart.
    const side = Math.max(job.width, Math.min(960, job.width * 4));
    for (const canvas of [this.picture, this.overlay]) {
      canvas.style.width = `${side}px`;
      canvas.style.aspectRatio = `${job.width} / ${job.height}`;
    }
    this.drawGrid();
    this.picture.setAttribute('aria-label', `Frame ${frame} of ${job.name || job.scene}`);
    return this.update();
  }

  /** Draws what has come since. Calls during a call make it look once more. */
  async update() {
    if (this.finished && this.shown) return;
    if (this.busy) { this.again = true; return; }
    this.busy = true;
    const run = this.run;
    try {
      do {
        this.again = false;
        await this.load(run);
      } while (this.again && run === this.run);
    } catch (error) {
      if (run === this.run) this.state.textContent = error.message;
    } finally {
      if (run === this.run) this.busy = false;
    }
  }

  get path() { return `/api/jobs/${this.job.id}/frames/${this.frame}`; }

  async load(run) {
    const answer = await ask(`${this.path}/tiles${this.cursor ? `?after=${this.cursor}` : ''}`);
    if (run !== this.run) return;
    if (answer.whole) this.times.clear();
    this.cursor = answer.cursor || '';
    for (const [tile, time] of answer.tiles) {
      if (time != null) this.times.set(tile, time);
      if (!this.drawn.has(tile)) this.wanted.add(tile);
    }
    this.finished = answer.frame.state === 'finished';
    this.describe(answer.frame);
    if (this.finished) await this.drawFinished(run, answer.frame); else await this.drawTiles(run);
    if (run === this.run) this.drawHeat();
  }

  async drawTiles(run) {
    const columns = Math.ceil(this.job.width / kTile);
    while (this.wanted.size > 0 && run === this.run) {
      const tiles = [...this.wanted].slice(0, kStrip);
      const answer = await fetch(`${this.path}/tiles.png?tiles=${tiles.join(',')}`);
      for (const tile of tiles) this.wanted.delete(tile);
      if (!answer.ok) return;  // The frame has been finished meanwhile: the next look shows it.
      const there = (answer.headers.get('X-Shutterline-Tiles') || '').split(',').map(Number);
      const strip = await createImageBitmap(await answer.blob());
      if (run !== this.run) return;
      const draw = this.picture.getContext('2d');
      there.forEach((tile, i) => {
        const x = tile % columns * kTile, y = Math.floor(tile / columns) * kTile;
        const width = Math.min(kTile, this.job.width - x), height = Math.min(kTile, this.job.height - y);
        draw.drawImage(strip, 0, i * kTile, width, height, x, y, width, height);
        this.drawn.add(tile);
        if (this.job.order === 'coarse') this.standIn(tile, meanColour(strip, i * kTile, width, height));
      });
      strip.close();
    }
  }

  /** Gives the tiles around this one its colour, where they are missing and none nearer has come. */
  standIn(tile, colour) {
    const columns = Math.ceil(this.job.width / kTile), rows = Math.ceil(this.job.height / kTile);
    const column = tile % columns, row = Math.floor(tile / columns);
    const draw = this.picture.getContext('2d');
    draw.fillStyle = colour;
    for (let y = Math.max(0, row - kReach); y <= Math.min(rows - 1, row + kReach); y++) {
      for (let x = Math.max(0, column - kReach); x <= Math.min(columns - 1, column + kReach); x++) {
        const other = y * columns + x, distance = (x - column) ** 2 + (y - row) ** 2;
        if (this.drawn.has(other) || distance >= (this.standIns.get(other) ?? Infinity)) continue;
        this.standIns.set(other, distance);
        draw.fillRect(x * kTile, y * kTile, kTile, kTile);
      }
    }
  }

  async drawFinished(run, frame) {
    const answer = await fetch(`${this.path}/picture.png?side=2048&digest=${frame.digest.slice(0, 16)}`);
    if (!answer.ok) throw new Error((await answer.json().catch(() => ({}))).error || 'no picture');
    const picture = await createImageBitmap(await answer.blob());
    if (run !== this.run) return;
    this.picture.getContext('2d').drawImage(picture, 0, 0, this.job.width, this.job.height);
    picture.close();
    this.shown = true;
  }

  /** What has not come yet: a dark checker of tiles. */
  drawGrid() {
    const draw = this.picture.getContext('2d');
    draw.fillStyle = '#0d0f12';
    draw.fillRect(0, 0, this.job.width, this.job.height);
    draw.fillStyle = '#14171b';
    for (let y = 0; y < this.job.height; y += kTile) {
      for (let x = (y / kTile % 2) * kTile; x < this.job.width; x += 2 * kTile) draw.fillRect(x, y, kTile, kTile);
    }
  }

  describe(frame) {
    const done = `${frame.tiles_done.toLocaleString('en')} of ${frame.tiles_total.toLocaleString('en')} tiles`;
    this.state.textContent = frame.state === 'finished' ? `Frame ${frame.frame} is finished` : `Frame ${frame.frame}: ${done}`;
  }

  setHeat(on) {
    this.heat = on;
    this.drawHeat();
  }

  drawHeat() {
    const draw = this.overlay.getContext('2d');
    draw.clearRect(0, 0, this.overlay.width, this.overlay.height);
    this.legend.hidden = !this.heat;
    if (!this.heat || !this.job) return;
    const times = [...this.times.values()].filter((time) => time > 0);
    if (times.length === 0) {
      this.low.textContent = 'No tile times are kept of this frame';
      this.high.textContent = '';
      return;
    }
    // A logarithm, because a few tiles often take a hundred times as long as most.
    const low = Math.min(...times), high = Math.max(...times);
    const span = Math.log(high / low) || 1;
    const columns = Math.ceil(this.job.width / kTile);
    for (const [tile, time] of this.times) {
      const [red, green, blue] = heatColour(Math.log(Math.max(time, low) / low) / span);
      draw.fillStyle = `rgb(${red} ${green} ${blue} / 0.78)`;
      draw.fillRect(tile % columns * kTile, Math.floor(tile / columns) * kTile, kTile, kTile);
    }
    this.low.textContent = seconds(low);
    this.high.textContent = seconds(high);
  }
}
