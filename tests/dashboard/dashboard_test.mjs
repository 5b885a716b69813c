// The dashboard in a real browser, over a real farm: node dashboard_test.mjs PROGRAMS NPM CHROMIUM [PICTURES]
//
// PROGRAMS: folder of the built programs; NPM: folder with node_modules; PICTURES: where to write the pictures
// of docs/images. Exits with 0 where everything held.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import {createRequire} from 'node:module';
import path from 'node:path';
import {Farm, until} from './farm.mjs';

const [programs, npm, chromiumPath, pictures] = process.argv.slice(2);
const {chromium} = createRequire(path.join(npm, 'package.json'))('playwright-core');
const kSize = pictures ? '1152x648' : '270x200';
const kScene = pictures ? 'debris' : 'debris';
const kSlow = ['--integrator', 'reference', '--spp', pictures ? '16' : '64'];

const farm = new Farm(programs);
const browser = await chromium.launch({executablePath: chromiumPath, args: ['--no-sandbox', '--disable-gpu']});
const page = await browser.newPage({viewport: {width: 1280, height: 860}, colorScheme: 'dark'});
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
/** The pixels of a canvas, and how many of them are none of the grid's greys of tiles that have not come. */
const pixels = (selector) => page.evaluate((where) => {
  const canvas = document.querySelector(where);
  const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let drawn = 0;
  for (let i = 0; i < data.length; i += 4) {
    const grid = (data[i] === 13 && data[i + 1] === 15 && data[i + 2] === 18) ||
                 (data[i] === 20 && data[i + 1] === 23 && data[i + 2] === 27);
    if (data[i + 3] > 0 && !grid) drawn++;
  }
  return {width: canvas.width, height: canvas.height, drawn, data: Array.from(data)};
}, selector);
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
  const scene = await farm.scene(kScene);
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
  assert.equal((await pixels('#picture')).drawn, 0);

  step('it fills tile by tile');
  const worker = farm.startWorker();
  const counts = [];
  let middle = null;
  await until('the first frame is finished', async () => {
    if (await page.locator('#frame-3.finished').count()) return true;
    if (await page.evaluate(() => document.getElementById('frame-select').value) !== '3') return false;
    const now = await pixels('#picture');
    if (now.drawn !== counts.at(-1)) counts.push(now.drawn);
    if (!middle && now.drawn > now.width * now.height / 3) {
      middle = now;
      await picture('job');
    }
    return false;
  }, 300);
  assert.ok(counts.length >= 4, `seen growing only ${counts.length} times`);
  assert.deepEqual(counts, [...counts].sort((a, b) => a - b), 'the picture never shrinks');
  assert.ok(middle, 'caught in the middle');

  step('the finished frame is the preview of the client, pixel by pixel');
  await page.locator('#frame-3').click();
  await until('frame 3 is drawn', async () => (await text('#frame-state')).includes('finished'));
  const preview = path.join(farm.folder, 'frame.exr');
  await farm.client('fetch', job, '--frame', '3', '-o', preview, '--png');
  const encoded = fs.readFileSync(preview.replace('.exr', '.png')).toString('base64');
  const expected = await page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], {type: 'image/png'}));
    const canvas = new OffscreenCanvas(image.width, image.height);
    canvas.getContext('2d').drawImage(image, 0, 0);
    return Array.from(canvas.getContext('2d').getImageData(0, 0, image.width, image.height).data);
  }, encoded);
  const different = (data) => {
    let count = 0;
    for (let i = 0; i < expected.length; i++) count += data[i] !== expected[i];
    return count;
  };
  await until('the picture is whole', async () => different((await pixels('#picture')).data) === 0, 20);
  // In the middle of the frame every pixel was of the grid or final.
  for (let i = 0; i < expected.length; i += 4) {
    if (middle.data[i] === 13 || middle.data[i] === 20) continue;
    assert.equal(middle.data[i], expected[i], `pixel ${i / 4} of the unfinished frame`);
  }

  step('tile times are shown over it, by keyboard');
  await page.locator('#main').focus();
  await tabTo('#heat');
  assert.equal((await pixels('#overlay')).drawn, 0);
  await page.keyboard.press('Space');
  assert.ok((await pixels('#overlay')).drawn > expected.length / 4 * 0.9);
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
  await page.locator('#action-cancel').waitFor();
  await tabTo('#action-cancel');
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
      await until('the frame is drawn', async () => (await text('#frame-state')).includes('finished'));
      await until('pixels', async () => (await pixels('#picture')).drawn > 0);
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
  await until('the frame is drawn', async () => (await text('#frame-state')).includes('finished'));
  await until('pixels', async () => (await pixels('#picture')).drawn > 0);
  await picture('light');

  step('another site may not cancel');
  const other = await submit('0-9');
  await page.goto(`http://localhost:${farm.http}/`);
  const outcome = await page.evaluate(async (target) => {
    const body = JSON.stringify({action: 'cancel'});
    const asked = await fetch(target, {method: 'POST', headers: {'Content-Type': 'application/json', 'X-Shutterline-Request': '1'}, body})
      .then((answer) => answer.status, () => 'refused');
    const blind = await fetch(target, {method: 'POST', mode: 'no-cors', body}).then(() => 'sent', () => 'refused');
    return [asked, blind];
  }, `${home}api/jobs/${other}/control`);
  assert.equal(outcome[0], 'refused');
  assert.notEqual(JSON.parse(await farm.client('status', other, '--json')).state, 'cancelled');

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
