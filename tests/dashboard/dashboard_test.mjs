// The dashboard in a real browser, over a real farm: node dashboard_test.mjs PROGRAMS NPM CHROMIUM [PICTURES]
//
// PROGRAMS: folder of the built programs; NPM: folder with node_modules; PICTURES: where to write the pictures
// of docs/images. Exits with 0 where everything held.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import http from 'node:http';
import {createRequire} from 'node:module';
import path from 'node:path';
import {Farm, until} from './farm.mjs';

const [programs, npm, chromiumPath, pictures] = process.argv.slice(2);
const {chromium} = createRequire(path.join(npm, 'package.json'))('playwright-core');
const kSize = pictures ? '960x540' : '270x200';
const kPixels = kSize.split('x').reduce((width, height) => width * height);
// In float: the tiles of an unfinished frame are, and halves may round to another shade.
const kSlow = ['--float', ...pictures ? [] : ['--integrator', 'reference', '--spp', '64']];

const farm = new Farm(programs);
// Other tests may keep the machine busy, and in a container /dev/shm may be too small for a browser.
const kPatience = 120e3;
const browser = await chromium.launch({executablePath: chromiumPath, timeout: kPatience,
                                       args: ['--no-sandbox', '--disable-gpu', '--disable-dev-shm-usage']});
const page = await browser.newPage({viewport: {width: 1280, height: 860}, colorScheme: 'dark'});
page.setDefaultTimeout(kPatience);
const complaints = [];
page.on('pageerror', (error) => complaints.push(String(error)));
page.on('console', (message) => {
  // What a coordinator that is being restarted refuses is expected.
  if (message.type() === 'error' && !/Failed to load resource|ERR_/.test(message.text())) complaints.push(message.text());
});

const step = (text) => console.log(`- ${text}`);
const text = (selector) => page.locator(selector).innerText();
const picture = async (name) => {
  if (pictures) await page.screenshot({path: path.join(pictures, `dashboard-${name}.png`)});
};
/** How many pixels of a canvas are drawn: of neither of the greys of tiles that have not come. */
const drawn = (selector) => page.evaluate((where) => {
  const canvas = document.querySelector(where);
  const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let i = 0; i < data.length; i += 4) {
    const grid = (data[i] === 13 && data[i + 1] === 15 && data[i + 2] === 18) ||
                 (data[i] === 20 && data[i + 1] === 23 && data[i + 2] === 27);
    if (data[i + 3] > 0 && !grid) count++;
  }
  return count;
}, selector);
/** Keeps the frame's pixels in the page under a name; where they come from a file, they are given as base64. */
const keep = (name, base64) => page.evaluate(async ([key, file]) => {
  let canvas = document.querySelector('#picture');
  if (file) {
    const bytes = Uint8Array.from(atob(file), (character) => character.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], {type: 'image/png'}));
    canvas = new OffscreenCanvas(image.width, image.height);
    canvas.getContext('2d').drawImage(image, 0, 0);
  }
  window.kept = window.kept || {};
  window.kept[key] = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
}, [name, base64]);
/** In how many pixels kept pictures differ, those apart that the second has no tile for. */
const differences = (first, second) => page.evaluate(([a, b]) => {
  const [left, right] = [window.kept[a], window.kept[b]];
  let count = left.length === right.length ? 0 : Infinity;
  for (let i = 0; i < left.length; i += 4) {
    const grid = (right[i] === 13 && right[i + 1] === 15) || (right[i] === 20 && right[i + 1] === 23);
    count += !grid && [0, 1, 2].some((c) => left[i + c] !== right[i + c]);
  }
  return count;
}, [first, second]);
/** Presses Tab until the element has the focus: it can be reached without a mouse. */
const tabTo = async (selector, limit = 40) => {
  for (let i = 0; i < limit; i++) {
    if (await page.evaluate((where) => document.activeElement?.matches(where), selector)) return;
    await page.keyboard.press('Tab');
  }
  assert.fail(`${selector} cannot be reached by Tab`);
};
const overflow = () => page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);

async function main() {
  await farm.startServer();
  const home = `http://127.0.0.1:${farm.http}/`;
  const scene = await farm.scene(pictures ? 'chess' : 'debris');
  const submit = (frames) => farm.client('submit', scene, '--size', kSize, '--frames', frames, ...kSlow);
  const job = await submit('3-4');
  const doomed = await submit('0-47');

  step('the list shows both jobs, and a new one by itself');
  await page.goto(home);
  await page.locator('#jobs li').nth(1).waitFor();
  await until('the page is live', async () => await text('#connection-word') === 'live');
  const late = await submit('7');
  await page.locator(`a[href="#/jobs/${late}"]`).waitFor();
  await farm.client('cancel', late);
  await page.locator(`a[href="#/jobs/${late}"] .state.cancelled`).waitFor();

  step('a frame is empty before its tiles come');
  await page.goto(`${home}#/jobs/${job}`);
  await page.locator('#page-job:not([hidden])').waitFor();
  await until('the frame is shown', async () => (await text('#frame-state')).includes('0 of'));
  assert.equal(await drawn('#picture'), 0);

  step('it fills tile by tile');
  const worker = farm.startWorker();
  const counts = [];
  let middle = false;
  await until('the first frame is finished', async () => {
    const now = await drawn('#picture');
    // Asked afterwards: of a finished frame the page may have gone on to the next one meanwhile.
    if (await page.locator('#frame-3.finished').count()) return true;
    if (now !== counts.at(-1)) counts.push(now);
    if (!middle && now > (pictures ? kPixels / 3 : 0)) {
      // Paused, or a busy machine may finish the frame before the browser looks again.
      await farm.client('pause', job);
      await keep('middle');
      await picture('job');
      middle = await drawn('#picture') < kPixels * 0.9;
      await farm.client('resume', job);
    }
    return false;
  }, 300);
  assert.ok(counts.length >= 4, `seen growing only ${counts.length} times: ${counts}`);
  assert.deepEqual(counts, [...counts].sort((a, b) => a - b), 'the picture never shrinks');
  assert.ok(middle, `caught in the middle: ${counts} of ${kPixels}`);

  step('the finished frame is the preview of the client, pixel by pixel');
  await page.locator('#frame-3').click();
  const preview = path.join(farm.folder, 'frame.exr');
  await farm.client('fetch', job, '--frame', '3', '-o', preview, '--png');
  await keep('preview', fs.readFileSync(preview.replace('.exr', '.png')).toString('base64'));
  await until('the picture is whole', async () => {
    await keep('finished');
    return await drawn('#picture') > 0.99 * kPixels && await differences('preview', 'finished') === 0;
  }, 60);
  assert.equal(await differences('preview', 'middle'), 0, 'in the middle of the frame every drawn pixel was final');

  step('tile times are shown over it, by keyboard');
  await page.locator('#main').focus();
  await tabTo('#heat');
  assert.equal(await drawn('#overlay'), 0);
  await page.keyboard.press('Space');
  assert.ok(await drawn('#overlay') > 0.9 * kPixels);
  assert.match(await text('#heat-low'), /\d/);
  await picture('heat');
  await page.keyboard.press('Space');

  step('frames are chosen by arrows');
  await tabTo('#frames');
  await page.keyboard.press('ArrowRight');
  await until('frame 4 is chosen', async () => await page.locator('#frame-4[aria-selected=true]').count() === 1);

  step('a job is cancelled by keyboard');
  await page.goto(home);
  await page.locator('#jobs li').nth(2).waitFor();
  await picture('jobs');
  await page.locator('#main').focus();
  await tabTo(`a[href="#/jobs/${doomed}"]`);
  await page.keyboard.press('Enter');
  await page.locator('#action-pause').waitFor();
  await tabTo('#action-pause');
  await page.keyboard.press('Enter');
  await page.locator('#action-resume').waitFor();
  assert.equal(JSON.parse(await farm.client('status', doomed, '--json')).paused, true);
  await tabTo('#action-cancel');
  await farm.client('resume', doomed);
  await page.locator('#action-pause').waitFor();
  assert.ok(await page.evaluate(() => document.activeElement.id === 'action-cancel'), 'the focus stays on its button');
  await page.keyboard.press('Enter');
  await page.locator('#confirm[open]').waitFor();
  await page.keyboard.press('Escape');
  assert.equal(await page.locator('#confirm[open]').count(), 0);
  assert.notEqual(JSON.parse(await farm.client('status', doomed, '--json')).state, 'cancelled');
  await tabTo('#action-cancel');
  await page.keyboard.press('Enter');
  await tabTo('#confirm-yes');
  await page.keyboard.press('Enter');
  await page.locator('#job-meter.cancelled').waitFor();
  assert.equal(JSON.parse(await farm.client('status', doomed, '--json')).state, 'cancelled');
  assert.equal(await page.locator('#action-cancel').count(), 0);

  step('workers are listed');
  await page.goto(`${home}#/workers`);
  await page.locator('#workers tr').waitFor();
  assert.match(await text('#workers'), /workstation-7/);

  step('it fits a phone');
  await page.setViewportSize({width: 390, height: 844});
  for (const where of ['', `#/jobs/${job}`, '#/workers']) {
    await page.goto(home + where);
    await page.locator('main > section:not([hidden])').waitFor();
    await until('the page is live', async () => await text('#connection-word') === 'live');
    assert.ok(await overflow() <= 0, `${where || 'the list'} is ${await overflow()} pixels too wide`);
    if (where.includes('jobs')) {
      await page.reload();
      await until('the picture is drawn', async () => await drawn('#picture') > 0.9 * kPixels);
      await picture('phone');
    }
    const small = await page.evaluate(() => [...document.querySelectorAll('main button, main select')]
      .filter((element) => element.offsetParent && element.getBoundingClientRect().height < 34).map((element) => element.id));
    assert.deepEqual(small, [], 'too small for a finger');
  }
  await page.setViewportSize({width: 1280, height: 860});

  step('light where the system is light');
  const background = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const dark = await background();
  await page.emulateMedia({colorScheme: 'light'});
  assert.notEqual(await background(), dark);
  await page.goto(`${home}#/jobs/${job}`);
  await page.reload();
  await until('the picture is drawn', async () => await drawn('#picture') > 0.9 * kPixels);
  await picture('light');

  step('a page that was left does not take the place of the next one');
  let release;
  const held = new Promise((resolve) => { release = resolve; });
  await page.route('**/api/throughput', async (request) => { await held; await request.continue(); });
  const followed = [];
  page.on('request', (request) => { if (request.url().includes('/events')) followed.push(request.url()); });
  await page.goto(home);
  await page.locator('#jobs li').nth(2).waitFor();
  assert.equal(await text('#connection-word'), 'connecting', 'the list follows nothing yet');
  await page.goto(`${home}#/jobs/${job}`);
  await until('the page is live', async () => await text('#connection-word') === 'live');
  release();
  await until('the list has heard', () => page.evaluate(() => document.querySelector('#chart-now').textContent !== ''));
  await page.unroute('**/api/throughput');
  await page.goto(`${home}#/workers`);
  await until('the page is live', async () => await text('#connection-word') === 'live');
  assert.deepEqual(followed.map((url) => url.slice(home.length - 1)), [`/events?job=${job}`, '/events']);

  step('what is not there is told');
  await page.goto(`${home}#/nowhere`);
  await page.locator('#page-missing:not([hidden])').waitFor();
  await until('the page is live', async () => await text('#connection-word') === 'live');

  step('another site may not cancel');
  const other = await submit('0-9');
  const foreign = http.createServer((_, answer) => answer.setHeader('Content-Type', 'text/html').end('<p>elsewhere'));
  await new Promise((resolve) => foreign.listen(0, '127.0.0.1', resolve));
  const stranger = await browser.newPage();
  await stranger.goto(`http://localhost:${foreign.address().port}/`);
  const outcomes = await stranger.evaluate(async ([base, control]) => {
    const body = JSON.stringify({action: 'cancel'});
    const outcome = (path, options) => fetch(base + path, options).then((answer) => answer.type, () => 'refused');
    const headers = {'Content-Type': 'application/json', 'X-Shutterline-Request': '1'};
    return [await outcome(control, {method: 'POST', headers, body}), await outcome('api/jobs'),
            await outcome(control, {method: 'POST', mode: 'no-cors', body})];
  }, [home, `api/jobs/${other}/control`]);
  // The last one is sent blindly: the coordinator refuses it, and the browser keeps the answer from the page.
  assert.deepEqual(outcomes, ['refused', 'refused', 'refused']);
  assert.notEqual(JSON.parse(await farm.client('status', other, '--json')).state, 'cancelled');
  await stranger.close();
  foreign.close();

  step('it comes back by itself after a restart of the coordinator');
  await page.goto(home);
  await until('the page is live', async () => await text('#connection-word') === 'live');
  farm.server.kill('SIGKILL');
  await farm.server.ended;
  await until('the loss is told', async () => await text('#connection-word') === 'reconnecting');
  await farm.startServer();
  await until('the page is live again', async () => await text('#connection-word') === 'live');
  worker.kill('SIGKILL');

  assert.deepEqual(complaints, [], 'the browser complains of nothing');
}

let failed = false;
try {
  await main();
  console.log('all held');
} catch (error) {
  failed = true;
  console.error(error);
  await page.screenshot({path: path.join(process.cwd(), 'dashboard-failure.png')}).catch(() => {});
  console.error(complaints.join('\n'), farm.logs());
}
await browser.close();
await farm.end();
process.exit(failed ? 1 : 0);
