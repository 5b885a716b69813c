// A coordinator, workers and clients as real processes below one temporary folder.
import {execFile, spawn} from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import {promisify} from 'node:util';

const run = promisify(execFile);

/** Waits until `look` gives something true, which is returned. */
export async function until(what, look, seconds = 120) {
  const end = Date.now() + seconds * 1000;
  for (;;) {
    const seen = await look();
    if (seen) return seen;
    if (Date.now() > end) throw new Error(`waited ${seconds} s in vain: ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

export class Farm {
  constructor(programs) {
    this.programs = programs;
    this.folder = fs.mkdtempSync(path.join(os.tmpdir(), 'shutterline-dashboard.'));
    this.processes = new Set();
    this.grpc = this.http = '0';
  }

  start(name, ...args) {
    const log = fs.openSync(path.join(this.folder, `${name}.log`), 'a');
    const child = spawn(path.join(this.programs, name), args, {stdio: ['ignore', 'ignore', log]});
    child.ended = new Promise((resolve) => child.on('exit', resolve));
    this.processes.add(child);
    child.on('exit', () => this.processes.delete(child));
    return child;
  }

  /** On free ports the first time, and on the same ones after that. */
  async startServer() {
    const files = ['port', 'http'].map((name) => path.join(this.folder, name));
    for (const file of files) fs.rmSync(file, {force: true});
    const start = () => {
      this.server = this.start('shutterline-server', '--listen', `127.0.0.1:${this.grpc}`, '--port-file', files[0],
        '--http', `127.0.0.1:${this.http}`, '--http-port-file', files[1], '--data', path.join(this.folder, 'data'));
    };
    start();
    await until('the coordinator serves', () => {
      if (fs.existsSync(files[1])) return true;
      // The second time: while it was away, its port may have become that of somebody's connection for a moment.
      if (this.server.exitCode != null && this.grpc === '0') throw new Error('the coordinator does not start');
      if (this.server.exitCode != null) start();
      return false;
    });
    [this.grpc, this.http] = files.map((file) => fs.readFileSync(file, 'utf8').trim());
  }

  startWorker() {
    return this.start('shutterline-worker', '--coordinator', `127.0.0.1:${this.grpc}`, '--name', 'workstation-7',
      '--threads', '1', '--cache-dir', path.join(this.folder, 'cache'));
  }

  async client(...args) {
    const {stdout} = await run(path.join(this.programs, 'shutterline'), [...args, '--server', `127.0.0.1:${this.grpc}`]);
    return stdout.trim();
  }

  async scene(name) {
    const file = path.join(this.folder, `${name}.glb`);
    await run(path.join(this.programs, 'shutterline-scenes'), [name, '-o', file]);
    return file;
  }

  /** Everything that ran said this. */
  logs() {
    return fs.readdirSync(this.folder).filter((name) => name.endsWith('.log'))
      .map((name) => `--- ${name}\n${fs.readFileSync(path.join(this.folder, name), 'utf8').slice(-4000)}`).join('');
  }

  async end() {
    const ends = [...this.processes].map((child) => { child.kill('SIGKILL'); return child.ended; });
    await Promise.all(ends);
    fs.rmSync(this.folder, {recursive: true, force: true});
  }
}
