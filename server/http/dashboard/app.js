// The dashboard: pages, and what keeps them up to date. Texts come from strangers (names of jobs, errors):
// they go in as text, never as markup.
import {ask, control, Live} from './live.js';
import {bytes, drawThroughput, rate, seconds} from './charts.js';
import {FrameView} from './frame_view.js';

const $ = (id) => document.getElementById(id);
const kEnded = ['succeeded', 'failed', 'cancelled', 'partial'];
const kMaxFrames = 500;  // Of the list; the others are reached by their numbers.
const ended = (job) => kEnded.includes(job.state);
const number = (value) => value.toLocaleString('en');
const percent = (job) => job.tiles_total ? Math.floor(100 * job.tiles_done / job.tiles_total) : 0;

function make(tag, className, text) {
  const element = document.createElement(tag);
  if (className) element.className = className;
  if (text != null) element.textContent = text;
  return element;
}

function toast(text) {
  $('toast').textContent = text;
  $('toast').classList.add('shown');
  clearTimeout(toast.timer);
  toast.timer = setTimeout(() => $('toast').classList.remove('shown'), 5000);
}

const kConnections = {opening: 'connecting', live: 'live', lost: 'reconnecting'};
function showConnection(state) {
  $('connection').className = `connection ${state}`;
  $('connection-word').textContent = kConnections[state];
}
const live = new Live(showConnection);

function showTotals(farm) {
  $('total-workers').textContent = number(farm.workers);
  $('total-rate').textContent = rate(farm.tiles_per_second);
  $('total-queued').textContent = number(farm.queued_tiles);
}

// --- Jobs --------------------------------------------------------------------------------------------

const jobs = new Map();  // By id, with their elements.
let chartTimer;

function describeRange(job) {
  const step = job.step === 1 ? '' : ` in steps of ${job.step}`;
  return job.frames_total === 1 ? `frame ${job.first}` : `frames ${job.first}–${job.last}${step}`;
}

function jobRow(job) {
  let row = jobs.get(job.id);
  if (!row) {
    const item = make('li'), link = make('a');
    link.href = `#/jobs/${job.id}`;
    row = {item, link, name: make('span', 'name'), state: make('span', 'state'), facts: make('span', 'facts'),
           percent: make('span', 'percent'), meter: make('div', 'meter'), bar: make('span')};
    row.meter.append(row.bar);
    link.append(row.name, row.state, row.facts, row.percent, row.meter);
    item.append(link);
    jobs.set(job.id, row);
  }
  row.job = job;
  row.name.textContent = job.name || job.scene;
  row.state.className = `state ${job.state}`;
  row.state.textContent = job.state;
  row.facts.textContent = `${job.width} × ${job.height}, ${describeRange(job)}, submitted ${ago(job.submitted)}`;
  row.percent.textContent = `${number(job.frames_finished)} of ${number(job.frames_total)} frames, ${percent(job)} %`;
  row.meter.className = `meter ${job.state}`;
  row.bar.style.width = `${percent(job)}%`;
  return row;
}

function ago(time) {
  const past = Math.max(0, (Date.now() - Date.parse(time)) / 1000);
  if (past < 60) return 'just now';
  if (past < 3600) return `${Math.floor(past / 60)} min ago`;
  if (past < 86400) return `${Math.floor(past / 3600)} h ago`;
  return new Date(time).toLocaleDateString();
}

function placeJob(job) {
  const known = jobs.has(job.id);
  const row = jobRow(job);
  if (!known) {
    const next = [...jobs.values()].filter((other) => other !== row && other.item.isConnected)
      .find((other) => other.job.submitted < job.submitted);
    $('jobs').insertBefore(row.item, next ? next.item : null);
  }
  summariseJobs();
}

function summariseJobs() {
  const all = [...jobs.values()].map((row) => row.job);
  const running = all.filter((job) => !ended(job)).length;
  $('jobs-summary').textContent = all.length === 0 ? '' : running === 0 ? 'Nothing to do' : `${running} to do`;
  $('jobs-empty').hidden = all.length > 0;
}

let older = null;
async function loadJobs(before) {
  const answer = await ask(`/api/jobs?limit=50${before ? `&before=${before}` : ''}`);
  for (const job of answer.jobs) {
    if (!jobs.has(job.id)) $('jobs').append(jobRow(job).item); else jobRow(job);
  }
  older = answer.before;
  $('jobs-more').hidden = older == null;
  summariseJobs();
}

async function drawChart() {
  const data = await ask('/api/throughput');
  const top = drawThroughput($('chart'), data);
  const last = data.tiles.at(-2) / data.step_seconds;
  $('chart-now').textContent = `${rate(last)} tiles/s now, ${rate(top)} at most`;
}

async function showJobs(left) {
  jobs.clear();
  $('jobs').replaceChildren();
  await loadJobs();
  await drawChart();
  if (left()) return;
  chartTimer = setInterval(() => drawChart().catch(() => {}), 5000);
  live.follow('/events', {farm: showTotals, job: placeJob});
}

// --- One job -----------------------------------------------------------------------------------------

const view = new FrameView({picture: $('picture'), overlay: $('overlay'), state: $('frame-state'),
                            legend: $('heat-legend'), low: $('heat-low'), high: $('heat-high')});
let current = null;  // {job, frames: Map, cells: Map, frame}

function numbersOf(job) {
  const from = Date.parse(job.submitted), to = job.ended ? Date.parse(job.ended) : Date.now();
  const rows = [['State', job.state], ['Tiles', `${number(job.tiles_done)} / ${number(job.tiles_total)}`],
                ['Frames', `${number(job.frames_finished)} / ${number(job.frames_total)}`],
                [job.ended ? 'Took' : 'Since', seconds(Math.max(0, (to - from) / 1000))]];
  if (!ended(job)) rows.push(['Remaining', current.left == null ? '–' : `about ${seconds(current.left)}`]);
  if (!ended(job)) rows.push(['Workers', number(job.workers)]);
  if (job.paused && !ended(job)) rows.push(['Paused', 'yes']);
  for (const id of ended(job) ? [] : job.waits_for) rows.push(['Waits for', id]);
  if (job.tiles_quarantined > 0) rows.push(['Missing tiles', number(job.tiles_quarantined), 'wrong']);
  if (job.mismatched_tiles > 0) rows.push(['Mismatched tiles', number(job.mismatched_tiles), 'wrong']);
  return rows;
}

/** The time left at the pace of the last half minute. */
function estimate(job) {
  const now = performance.now() / 1000;
  current.pace = (current.pace || []).filter((sample) => now - sample[0] < 30);
  current.pace.push([now, job.tiles_done]);
  const [then, done] = current.pace[0];
  current.left = job.tiles_done > done ? (job.tiles_total - job.tiles_done) * (now - then) / (job.tiles_done - done) : null;
}

function showJob(job) {
  current.job = job;
  estimate(job);
  document.title = `${percent(job)} % ${job.name || job.scene}, Shutterline`;
  $('job-title').textContent = job.name || job.scene;
  $('job-facts').textContent = `${job.scene}, ${job.width} × ${job.height}, ${describeRange(job)}`;
  $('job-error').hidden = !job.error;
  $('job-error').textContent = job.error;
  $('job-meter').className = `meter ${job.state}`;
  $('job-meter').firstElementChild.style.width = `${percent(job)}%`;
  $('job-meter').setAttribute('aria-valuenow', percent(job));
  $('job-numbers').replaceChildren(...numbersOf(job).map(([name, value, className]) => {
    const pair = make('div', className);
    pair.append(make('dt', '', name), make('dd', '', value));
    return pair;
  }));
  showQuarantine(job);
  showActions(job);
}

/** Tiles that are not tried any more, with their evidence: asked for where there are others than are shown. */
async function showQuarantine(job) {
  $('quarantine').hidden = job.tiles_quarantined === 0;
  const wanted = `${job.id} ${job.tiles_quarantined}`;
  if (job.tiles_quarantined === 0 || $('quarantine-list').dataset.shown === wanted) return;
  $('quarantine-list').dataset.shown = wanted;
  const {quarantined} = await ask(`/api/jobs/${job.id}/quarantined`).catch(() => ({quarantined: []}));
  $('quarantine-list').replaceChildren(...quarantined.map((tile) => {
    const item = make('li', '', `Frame ${tile.frame}, tile ${tile.tile}`);
    const words = tile.evidence.map((trouble) =>
      `${trouble.worker_name || trouble.worker_uuid} ${trouble.worker_ended ? 'ended' : 'failed'}: ${trouble.reason}` +
      (trouble.log_tail ? `\n  ${trouble.log_tail.trimEnd().replaceAll('\n', '\n  ')}` : ''));
    item.append(make('pre', '', words.join('\n')));
    return item;
  }));
}

const kActions = {
  cancel: {word: 'Cancel job', className: 'danger', title: 'Cancel this job?', yes: 'Cancel job',
           text: 'Tiles that are being rendered are dropped. Frames that are finished stay.'},
  pause: {word: 'Pause'}, resume: {word: 'Resume'}, retry: {word: 'Retry'},
};

let mayControl = false;  // Until the coordinator says that we may.

function actionsOf(job) {
  if (!mayControl) return [];
  if (ended(job)) return job.state === 'succeeded' ? [] : ['retry'];
  return [...job.tiles_quarantined > 0 ? ['retry'] : [], job.paused ? 'resume' : 'pause', 'cancel'];
}

function showActions(job) {
  const wanted = actionsOf(job).filter((action) => kActions[action]);
  const bar = $('job-actions');
  // Buttons that stay are left where they are, and so is the focus.
  for (const button of [...bar.children]) if (!wanted.includes(button.dataset.action)) button.remove();
  wanted.forEach((action, i) => {
    if (bar.children[i]?.dataset.action === action) return;
    const button = make('button', kActions[action].className || '', kActions[action].word);
    button.id = `action-${action}`;
    button.dataset.action = action;
    button.addEventListener('click', () => act(action));
    bar.insertBefore(button, bar.children[i] ?? null);
  });
}

async function act(action) {
  const {title, text, yes} = kActions[action];
  if (title && !await confirmed(title, text, yes)) return;
  try {
    showJob(await control(current.job.id, action));
    toast(`Done: ${kActions[action].word.toLowerCase()}.`);
    $('main').focus();
  } catch (error) {
    toast(error.message);
  }
}

function confirmed(title, text, yes) {
  $('confirm-title').textContent = title;
  $('confirm-text').textContent = text;
  $('confirm-yes').textContent = yes;
  $('confirm').returnValue = 'no';
  $('confirm').showModal();
  return new Promise((resolve) => {
    $('confirm').addEventListener('close', () => resolve($('confirm').returnValue === 'yes'), {once: true});
  });
}

function cellOf(frame) {
  let cell = current.cells.get(frame.frame);
  if (!cell) {
    if (current.cells.size >= kMaxFrames) return null;
    cell = make('div', 'cell', frame.frame);
    cell.setAttribute('role', 'option');
    cell.id = `frame-${frame.frame}`;
    cell.addEventListener('click', () => selectFrame(frame.frame, true));
    current.cells.set(frame.frame, cell);
    $('frames').append(cell);
  }
  cell.classList.toggle('finished', frame.state === 'finished');
  cell.style.setProperty('--done', `${Math.round(100 * frame.tiles_done / frame.tiles_total)}%`);
  cell.setAttribute('aria-label', `Frame ${frame.frame}, ${frame.state}`);
  cell.title = frame.size_bytes ? `${bytes(frame.size_bytes)}` : `${frame.tiles_done} of ${frame.tiles_total} tiles`;
  return cell;
}

function selectFrame(frame, byHand) {
  if (byHand) $('follow').checked = false;
  if (current.frame === frame) return;
  current.frame = frame;
  for (const [other, cell] of current.cells) cell.setAttribute('aria-selected', other === frame);
  const cell = current.cells.get(frame);
  $('frames').setAttribute('aria-activedescendant', cell ? cell.id : '');
  if (cell && byHand) cell.scrollIntoView({block: 'nearest'});
  $('frame-select').value = frame;
  const index = (frame - current.job.first) / current.job.step;
  $('frame-previous').disabled = index <= 0;
  $('frame-next').disabled = index >= current.job.frames_total - 1;
  view.show(current.job, frame);
}

function stepFrame(by) {
  const {first, step, frames_total: total} = current.job;
  const index = (current.frame - first) / step + by;
  if (index >= 0 && index < total) selectFrame(first + index * step, true);
}

function onFrame(frame) {
  current.frames.set(frame.frame, frame);
  cellOf(frame);
  if ($('follow').checked && frame.state === 'running' && frame.frame !== current.frame) {
    const shown = current.frames.get(current.frame);
    if (!shown || shown.state !== 'running') selectFrame(frame.frame);
  }
  if (frame.frame === current.frame) view.update();
}

async function openJob(id, left) {
  const job = await ask(`/api/jobs/${id}`);
  if (left()) return;
  current = {job, frames: new Map(), cells: new Map(), frame: null};
  $('frames').replaceChildren();
  $('follow').checked = true;
  showJob(job);
  const {frames} = await ask(`/api/jobs/${id}/frames?limit=${kMaxFrames}`);
  if (left()) return;
  for (const frame of frames) { current.frames.set(frame.frame, frame); cellOf(frame); }
  $('frames-note').textContent = job.frames_total > kMaxFrames
    ? `The first ${kMaxFrames} of ${number(job.frames_total)}; the others by ‹ and ›.` : '';
  $('frame-select').replaceChildren(...frames.map((frame) => make('option', '', frame.frame)));
  const start = frames.find((frame) => frame.state === 'running') || frames.findLast((frame) => frame.state === 'finished') || frames[0];
  selectFrame(start.frame);
  live.follow(`/events?job=${id}`, {farm: showTotals, job: showJob, frame: onFrame});
}

// --- Workers -----------------------------------------------------------------------------------------

let workersTimer;
async function loadWorkers() {
  const {workers} = await ask('/api/workers');
  const slots = workers.reduce((sum, worker) => sum + worker.slots, 0);
  $('workers-summary').textContent = workers.length ? `${workers.length} connected, ${slots} slots` : '';
  $('workers-empty').hidden = workers.length > 0;
  $('workers').replaceChildren(...workers.map((worker) => {
    const row = make('tr');
    row.append(make('td', '', worker.name + (worker.draining ? ' (draining)' : '')), make('td', '', worker.slots),
               make('td', '', number(worker.leased_tiles)), make('td', '', number(worker.tiles_done)),
               make('td', '', seconds(worker.tile_seconds)), make('td', '', seconds(worker.silent_seconds)),
               make('td', '', worker.isa));
    row.title = `${worker.uuid}, build ${worker.build}`;
    return row;
  }));
}

async function showWorkers(left) {
  await loadWorkers();
  if (left()) return;
  workersTimer = setInterval(() => loadWorkers().catch(() => {}), 2000);
  live.follow('/events', {farm: showTotals});
}

// --- Pages -------------------------------------------------------------------------------------------

let visits = 0;

function showSection(page) {
  for (const section of document.querySelectorAll('main > section')) section.hidden = section.id !== `page-${page}`;
}

function showMissing(reason) {
  showSection('missing');
  $('missing-reason').textContent = reason;
  live.follow('/events', {farm: showTotals});
}

async function route() {
  // What a page that has been left still waits for must not take the place of what the next one shows.
  const visit = ++visits, left = () => visit !== visits;
  clearInterval(chartTimer);
  clearInterval(workersTimer);
  live.close();
  showConnection('opening');
  const path = location.hash.slice(1) || '/';
  const job = path.match(/^\/jobs\/([0-9a-f-]{36})$/);
  const page = path === '/' ? 'jobs' : job ? 'job' : path === '/workers' ? 'workers' : 'missing';
  showSection(page);
  for (const link of document.querySelectorAll('nav a')) {
    if (link.dataset.page === page) link.setAttribute('aria-current', 'page'); else link.removeAttribute('aria-current');
  }
  document.title = 'Shutterline';
  try {
    if (page === 'jobs') await showJobs(left);
    if (page === 'job') await openJob(job[1], left);
    if (page === 'workers') await showWorkers(left);
    if (page === 'missing') showMissing('There is no such page.');
  } catch (error) {
    if (left()) return;
    if (error.status === 404) return showMissing(error.message);
    showConnection('lost');
    setTimeout(() => { if (!left()) route(); }, 3000);
  }
}

$('jobs-more').addEventListener('click', () => loadJobs(older).catch((error) => toast(error.message)));
$('frame-previous').addEventListener('click', () => stepFrame(-1));
$('frame-next').addEventListener('click', () => stepFrame(1));
$('frame-select').addEventListener('change', (event) => selectFrame(Number(event.target.value), true));
$('heat').addEventListener('change', (event) => view.setHeat(event.target.checked));
$('frames').addEventListener('keydown', (event) => {
  const by = {ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1}[event.key];
  if (!by) return;
  event.preventDefault();
  stepFrame(by);
});
window.addEventListener('hashchange', () => { route(); $('main').focus(); });
window.addEventListener('resize', () => { if (!$('page-jobs').hidden) drawChart().catch(() => {}); });

ask('/api/overview').then((overview) => { mayControl = overview.may_control; }, () => {}).then(route);
