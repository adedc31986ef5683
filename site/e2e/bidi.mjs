// Control an ordinary Firefox by WebDriver BiDi; Playwright would need its own build of Firefox.
import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

export const PROGRAM = [
  process.env.FIREFOX,
  "/usr/bin/firefox-esr",
  "/usr/bin/firefox",
  "/Applications/Firefox.app/Contents/MacOS/firefox",
].find((path) => path && existsSync(path));
/** The reason why tests can't run in Firefox here; false if they can. */
export const MISSING = !PROGRAM
  ? "no Firefox: FIREFOX=/path/to/firefox names one"
  : typeof WebSocket === "undefined"
    ? "no WebSocket in Node"
    : false;

const PREFERENCES = [
  ["app.update.disabledForTesting", true],
  ["browser.shell.checkDefaultBrowser", false],
  ["datareporting.policy.dataSubmissionEnabled", false],
  ["network.captive-portal-service.enabled", false],
  ["network.connectivity-service.enabled", false],
  ["toolkit.telemetry.enabled", false],
];

/** Firefox's message on a file that was still loading when the page was closed; it is not an error. */
const CUT_OFF = /A ServiceWorker intercepted the request and encountered an unexpected error/;
/** The message if there is no graphics card; spatial arms are then drawn without solid bodies. */
const WITHOUT_WEBGL = /^THREE\.WebGLRenderer: .*(WebGL context could not be created|Error creating WebGL context)/s;
const isHarmless = (text) => CUT_OFF.test(text) || WITHOUT_WEBGL.test(text);

/** Start a headless Firefox with an empty profile in a language; return it with one page to control. */
export async function firefox(speaks = "en-GB, en") {
  const profile = mkdtempSync(join(tmpdir(), "qdot-firefox-"));
  const lines = [...PREFERENCES, ["intl.accept_languages", speaks]].map(
    (each) => `user_pref(${each.map((part) => JSON.stringify(part)).join(", ")});`,
  );
  writeFileSync(join(profile, "user.js"), lines.join("\n"));
  const child = spawn(PROGRAM, ["--headless", "--no-remote", "--remote-debugging-port=0", "--profile", profile], {
    env: { ...process.env, TZ: "UTC" },
  });
  const address = await listening(child);
  const socket = new WebSocket(`${address}/session`);
  await new Promise((opened, failed) => {
    socket.onopen = opened;
    socket.onerror = () => failed(new Error(`no connection to ${address}`));
  });
  const waiting = new Map();
  const errors = [];
  socket.onmessage = ({ data }) => {
    const { id, type, result, message, method, params } = JSON.parse(data);
    if (method === "log.entryAdded" && params.level === "error" && !isHarmless(params.text)) errors.push(params.text);
    const [kept, refused] = waiting.get(id) ?? [];
    waiting.delete(id);
    if (type === "error") refused?.(new Error(message));
    else kept?.(result);
  };
  let count = 0;
  const send = (method, params = {}) =>
    new Promise((kept, refused) => {
      count += 1;
      waiting.set(count, [kept, refused]);
      socket.send(JSON.stringify({ id: count, method, params }));
    });
  const { capabilities } = await send("session.new", { capabilities: {} });
  await send("session.subscribe", { events: ["log.entryAdded"] });
  // Only a new window has the focus, without which keys don't press buttons.
  const { context } = await send("browsingContext.create", { type: "window" });
  await send("browsingContext.activate", { context });
  return {
    ...paged(send, context),
    /** Return the first frame of the page, which has the same methods as the page. */
    frame: async () => {
      const { contexts } = await send("browsingContext.getTree", { root: context });
      return paged(send, contexts[0].children[0].context);
    },
    errors,
    version: capabilities.browserVersion,
    async close() {
      await send("browser.close").catch(() => undefined);
      socket.close();
      if (child.exitCode === null) await new Promise((ended) => child.once("exit", ended));
      rmSync(profile, { recursive: true, force: true, maxRetries: 5, retryDelay: 200 });
    },
  };
}

/** Return the address on which the browser listens; it prints the address on stderr. */
function listening(child) {
  return new Promise((found, failed) => {
    let said = "";
    child.stderr.on("data", (piece) => {
      said += piece;
      const address = /WebDriver BiDi listening on (ws:\S+)/.exec(said)?.[1];
      if (address) found(address);
    });
    child.once("error", failed);
    child.once("exit", (code) => failed(new Error(`Firefox ended with ${code}: ${said.slice(-500)}`)));
  });
}

function paged(send, context) {
  /** Run a function in the page with plain values, and return its result; promises are awaited. */
  const run = async (body, ...values) => {
    const answer = await send("script.callFunction", {
      functionDeclaration: `async (values) => JSON.stringify((await (${body})(...JSON.parse(values))) ?? null)`,
      arguments: [{ type: "string", value: JSON.stringify(values) }],
      target: { context },
      awaitPromise: true,
      userActivation: true,
    });
    if (answer.type === "exception") throw new Error(answer.exceptionDetails.text);
    return JSON.parse(answer.result.value);
  };
  /** Run a function in the page until its result is truthy, and return the result. */
  const until = async (body, ...values) => {
    for (let tries = 0; tries < 150; tries += 1) {
      const found = await run(body, ...values);
      if (found) return found;
      await new Promise((later) => setTimeout(later, 100));
    }
    throw new Error(`not in time: ${body} of ${JSON.stringify(values)}`);
  };
  const actions = (type, id, steps, more = {}) =>
    send("input.performActions", { context, actions: [{ type, id, actions: steps, ...more }] });
  return {
    run,
    until,
    open: (url) => send("browsingContext.navigate", { context, url, wait: "complete" }),
    size: (width, height) => send("browsingContext.setViewport", { context, viewport: { width, height } }),
    shot: async () => Buffer.from((await send("browsingContext.captureScreenshot", { context })).data, "base64"),
    /** Keys, one after the other; names as in Keys. */
    keys: (...keys) =>
      actions(
        "key",
        "keyboard",
        keys.flatMap((value) => ["keyDown", "keyUp"].map((type) => ({ type, value }))),
      ),
    /** Press at one point, move to others, and release, with a mouse or a finger. */
    drag: (pointerType, [first, ...rest]) => {
      const moved = ([x, y]) => ({ type: "pointerMove", x: Math.round(x), y: Math.round(y), duration: 60 });
      const steps = [
        moved(first),
        { type: "pointerDown", button: 0 },
        ...rest.map(moved),
        { type: "pointerUp", button: 0 },
      ];
      return actions("pointer", `a ${pointerType}`, steps, { parameters: { pointerType } });
    },
  };
}

export const Keys = {
  right: "\uE014",
  up: "\uE013",
  down: "\uE015",
  home: "\uE011",
  enter: "\uE007",
  tab: "\uE004",
  space: " ",
};
