// What the coordinator says: answers of its API, and its events.

/** The JSON of an answer; an Error with the coordinator's reason otherwise. */
export async function ask(path, options) {
  const answer = await fetch(path, options);
  const json = await answer.json().catch(() => ({}));
  if (!answer.ok) throw Object.assign(new Error(json.error || `HTTP ${answer.status}`), {status: answer.status});
  return json;
}

/** Asks a job to change; the header is what other sites cannot send. */
export function control(job, action) {
  return ask(`/api/jobs/${job}/control`, {
    method: 'POST',
    headers: {'Content-Type': 'application/json', 'X-Shutterline-Request': '1'},
    body: JSON.stringify({action}),
  });
}

/** Follows events, and goes on after the last one when the connection was lost. */
export class Live {
  constructor(onState) {
    this.onState = onState;
    this.source = null;
  }
  follow(path, handlers) {
    this.close();
    const source = this.source = new EventSource(path);
    source.onopen = () => this.onState('live');
    source.onerror = () => {
      this.onState('lost');
      // Where the coordinator turned us away the browser gives up: try again ourselves.
      if (source.readyState === EventSource.CLOSED && source === this.source) {
        this.timer = setTimeout(() => this.follow(path, handlers), 3000);
      }
    };
    for (const [name, handler] of Object.entries(handlers)) {
      source.addEventListener(name, (event) => handler(JSON.parse(event.data)));
    }
  }
  close() {
    clearTimeout(this.timer);
    if (this.source) this.source.close();
    this.source = null;
  }
}
