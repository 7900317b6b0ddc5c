// The way to the server: one WebSocket that comes back by itself, jobs by number, results as frames.

/** Decode a result frame: a JSON head, then 32-bit floats (see docs/page.md). */
export function decode(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const numbers = new Float32Array(buffer, 4 + length);
  const full = (value) => {
    if (Array.isArray(value)) return value.map(full);
    if (value === null || typeof value !== "object") return value;
    const keys = Object.keys(value);
    if (keys.length === 2 && "at" in value && "shape" in value) {
      const size = value.shape.reduce((a, b) => a * b, 1);
      return Object.assign(numbers.subarray(value.at, value.at + size), { shape: value.shape });
    }
    return Object.fromEntries(keys.map((key) => [key, full(value[key])]));
  };
  return full(head);
}

const MOST_TEXT = 512 * 1024; // letters of a message that the server takes
const gone = () => Object.assign(new Error("The server is gone."), { kind: "gone" });

export class Wire {
  /** `onOpen` is called when the server comes and goes, `onReady` whether it can do jobs at once, `onUnkept` why a result is not kept. */
  constructor(onOpen, onReady, onUnkept) {
    Object.assign(this, { onOpen, onReady, onUnkept });
    this.jobs = new Map();
    this.next = 1;
    this.awaited = null;
    this.open();
  }

  open() {
    this.socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/wire`);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => this.onOpen(true);
    this.socket.onmessage = (event) => this.take(event.data);
    this.socket.onclose = () => {
      for (const job of [...this.jobs.values(), this.awaited?.job]) job?.reject(gone());
      this.awaited = null;
      this.jobs.clear();
      this.onOpen(false);
      setTimeout(() => this.open(), 700);
    };
  }

  get ready() { return this.socket.readyState === WebSocket.OPEN; }

  /** Submit a job; `onProgress` gets its share done. The promise has `number` for `cancel`. */
  submit(kind, words, onProgress = () => {}) {
    const number = this.next++;
    const promise = new Promise((resolve, reject) => {
      if (!this.ready) { reject(gone()); return; }
      const text = JSON.stringify({ ...words, kind, id: number });
      if (text.length > MOST_TEXT) { reject(Object.assign(new Error("The case is too large for the page: use gearplay run."), { kind: "error" })); return; }
      this.jobs.set(number, { resolve, reject, onProgress });
      this.socket.send(text);
    });
    return Object.assign(promise, { number });
  }

  cancel(number) { if (this.ready) this.socket.send(JSON.stringify({ kind: "cancel", id: number })); }

  take(data) {
    if (typeof data !== "string") {
      const { job, key } = this.awaited ?? {};
      this.awaited = null;
      try { job?.resolve({ ...decode(data), key }); } catch { job?.reject(Object.assign(new Error("The result came damaged. Run it again."), { kind: "error" })); }
      return;
    }
    const words = JSON.parse(data);
    if (words.type === "state") { this.onReady(words.ready); return; }
    if (words.type === "unkept") { this.onUnkept(words.error); return; }
    const job = this.jobs.get(words.id);
    if (words.type === "progress") { job?.onProgress(words.done); return; }
    this.jobs.delete(words.id);
    if (words.type === "result") { this.awaited = { job, key: words.key }; return; }
    const error = new Error(words.error);
    error.kind = words.type;
    job?.reject(error);
  }
}
