// Requests to the public API. A refusal and a silence are two things: one is an answer.

import { refusal } from "/static/person.js";
import { hear } from "/static/service-time.js";
import { inItsWords } from "/static/words.js";

const PATIENCE_MS = 8000;
const GATEWAY = [502, 504]; // said by something between here and the service
const BUSY = 503;
const REASON_MISSING = "TP-2006";
const AGAIN_MS = 1000;

export class Unreached extends Error {}

export class Refused extends Error {
  // `solved`: whoever was refused has shown since that they may, and presses once more.
  constructor(status, problem, solved = false) {
    super(problem?.detail ?? "");
    this.status = status;
    this.solved = solved;
    this.ofReason = problem?.code === REASON_MISSING;
    this.ofName = problem?.type === "urn:truepose:problem:name";
  }
}

async function reached(path, request, patience_ms) {
  const patience = new AbortController();
  const timer = patience_ms === null ? null : setTimeout(() => patience.abort(), patience_ms);
  try {
    const reply = await fetch(path, inItsWords({ cache: "no-store", ...request, signal: patience.signal }));
    if (!request.cache) hear(reply); // what was kept here tells the time of then
    return [reply, reply.status === 204 ? null : await bodyOf(reply)];
  } catch (error) {
    throw new Unreached(error.message);
  } finally {
    clearTimeout(timer);
  }
}

// What was cut off on its way is no answer, whatever its head said. A refusal may come as somebody else's page.
const bodyOf = (reply) => reply.json().catch((error) => (reply.ok ? Promise.reject(error) : null));

// `patience_ms` null: as long as it takes.
export async function ask(path, request = {}, patience_ms = PATIENCE_MS) {
  const [reply, answer] = await reached(path, request, patience_ms);
  if (GATEWAY.includes(reply.status)) throw new Unreached(String(reply.status));
  if (reply.ok) return answer;
  const { sentence, solved } = await refusal(answer, request.method);
  throw new Refused(reply.status, { ...answer, detail: sentence }, solved);
}

// Reads until the service has said something: a request that failed is no answer, nor is "not now".
export async function answerTo(read) {
  for (;;) {
    try {
      return await read();
    } catch (error) {
      if (error instanceof Refused && error.status !== BUSY) throw error;
    }
    await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
  }
}

const UNDER_WAY = ["queued", "running"];
const POLL_MS = 1000;

// What takes a while is a job of the service: it is asked after until it has made something, or says why not.
export async function made(path, body, key) {
  let job = await post(path, body, key, PATIENCE_MS, { Prefer: "respond-async" });
  if (!("result_id" in job)) return job.id; // it was made at once
  while (UNDER_WAY.includes(job.state)) {
    await new Promise((resolve) => setTimeout(resolve, POLL_MS));
    job = await ask(`/api/v1/jobs/${job.id}`);
  }
  if (job.result_id === null) throw new Refused(409, { detail: job.message });
  return job.result_id;
}

export function post(path, body, key = null, patience_ms = PATIENCE_MS, more = {}) {
  const headers = { "Content-Type": "application/json", ...more };
  if (key) headers["Idempotency-Key"] = key;
  return ask(path, { method: "POST", headers, body: JSON.stringify(body) }, patience_ms);
}
