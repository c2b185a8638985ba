// Calls of the service and its event stream. A token goes with every one of them.

const BASE = new URL("api/v1/", document.baseURI);
const TOKEN = "gtfdi.token";
/** How long an answer may take. */
const PATIENCE_MS = 10_000;
/** The service says something at least every 10 s: after this much silence the line is dead. */
const SILENCE_MS = 25_000;

/** What went wrong with a call; `status` is null where no answer came. */
export class ApiError extends Error {
  constructor(message, status = null, code = null) {
    super(message);
    this.status = status;
    this.code = code;
  }
}

/** Keeps the token until the tab is closed; null forgets it. */
export function setToken(token) {
  if (token === null) sessionStorage.removeItem(TOKEN);
  else sessionStorage.setItem(TOKEN, token);
}

/** Whether there is a token. */
export const hasToken = () => sessionStorage.getItem(TOKEN) !== null;

function headers(more = {}) {
  const token = sessionStorage.getItem(TOKEN);
  return token === null ? more : { ...more, Authorization: `Bearer ${token}` };
}

async function failure(response) {
  let told = null;
  try {
    told = (await response.json())?.error ?? null;
  } catch {
    // No JSON: the status has to do.
  }
  const message = told?.message ?? `the service answered ${response.status} ${response.statusText}`;
  return new ApiError(String(message), response.status, told?.code ?? null);
}

async function call(method, path, body) {
  const abort = new AbortController();
  const timer = setTimeout(() => abort.abort(), PATIENCE_MS);
  try {
    const response = await fetch(new URL(path, BASE), {
      method,
      headers: headers(body === undefined ? {} : { "Content-Type": "application/json" }),
      body: body === undefined ? undefined : JSON.stringify(body),
      signal: abort.signal,
      cache: "no-store",
      credentials: "same-origin",
    });
    if (!response.ok) throw await failure(response);
    const text = await response.text();
    return text === "" ? null : JSON.parse(text);
  } catch (error) {
    if (error instanceof ApiError) throw error;
    if (abort.signal.aborted) {
      throw new ApiError(`the service did not answer within ${PATIENCE_MS / 1000} s`);
    }
    if (error instanceof SyntaxError) throw new ApiError("the service's answer is not JSON");
    throw new ApiError("the service cannot be reached");
  } finally {
    clearTimeout(timer);
  }
}

/** The answer to a GET. */
export const get = (path) => call("GET", path);
/** The answer to a POST of an object. */
export const post = (path, body) => call("POST", path, body);
/** The answer to a DELETE. */
export const remove = (path) => call("DELETE", path);

/** A path whose parts may hold any character, and a query whose empty values are left out. */
export function path(parts, query = {}) {
  const entries = Object.entries(query).filter(([, value]) => value !== null && value !== "");
  const text = new URLSearchParams(entries).toString();
  return parts.map(encodeURIComponent).join("/") + (text ? `?${text}` : "");
}

/**
 * Listens to the event stream until it ends. `opened` is called once it stands, `event` with the
 * name and the data of each event.
 */
export async function listen({ opened, event }) {
  const abort = new AbortController();
  let timer = null;
  const alive = () => {
    clearTimeout(timer);
    timer = setTimeout(() => abort.abort(), SILENCE_MS);
  };
  alive();
  try {
    // EventSource cannot send a header.
    const response = await fetch(new URL("events", BASE), {
      headers: headers({ Accept: "text/event-stream" }),
      signal: abort.signal,
      cache: "no-store",
    });
    if (!response.ok) throw await failure(response);
    opened();
    const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
    const take = eventParser(event);
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      alive();
      take(value);
    }
  } catch (error) {
    if (error instanceof ApiError) throw error;
    if (abort.signal.aborted) {
      throw new ApiError(`nothing was heard from the service for ${SILENCE_MS / 1000} s`);
    }
    throw new ApiError("the connection to the service broke");
  } finally {
    clearTimeout(timer);
    abort.abort();
  }
}

/** Takes text of an event stream in pieces of any length, and gives each event to `event`. */
export function eventParser(event) {
  let rest = "";
  let name = "message";
  let data = [];
  return (piece) => {
    const lines = (rest + piece).split("\n");
    rest = lines.pop();
    for (const whole of lines) {
      const line = whole.endsWith("\r") ? whole.slice(0, -1) : whole;
      if (line === "") {
        if (data.length > 0) deliver(event, name, data.join("\n"));
        [name, data] = ["message", []];
      } else if (line.startsWith("event:")) name = line.slice(6).trim();
      else if (line.startsWith("data:")) data.push(line.slice(5).replace(/^ /, ""));
    }
  };
}

function deliver(event, name, text) {
  let data;
  try {
    data = JSON.parse(text);
  } catch {
    return; // One spoilt event is no reason to lose the next.
  }
  event(name, data);
}
