// A learning platform on another site shows qdot in a frame: in a browser with the usual settings, in one that blocks
// third-party cookies, and in one that stores no cookies in the frame at all, where the platform's storage replaces them
// (or a button opens a new tab, if the platform has none). Both servers speak HTTPS, as browsers demand it.
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { createPrivateKey, createPublicKey, createSign } from "node:crypto";
import { once } from "node:events";
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { request } from "node:http";
import { createServer } from "node:https";
import { createServer as createSocket } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, afterEach, before, test } from "node:test";

import { CHROMIUM, PATIENCE } from "../tools/browser.mjs";
import { submit } from "./service.mjs";

const QDOT = process.env.QDOT ?? "qdot";
const CLAIM = "https://purl.imsglobal.org/spec/lti/claim/";
const DEEP_LINKING = "https://purl.imsglobal.org/spec/lti-dl/claim/";
const ROLE = "http://purl.imsglobal.org/vocab/lis/v2/membership#";
const folder = mkdtempSync(join(tmpdir(), "qdot-lti-"));
const servers = [];
let service, platform, tool, login;
/** Whether the server in front of qdot lets cookies through. */
let hasCookies = true;

/** Serves HTTPS at a free port. */
async function serve(listener) {
  const [key, cert] = ["key.pem", "cert.pem"].map((name) => readFileSync(join(folder, name)));
  const server = createServer({ key, cert }, listener);
  servers.push(server);
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  return server.address().port;
}

const findFreePort = () =>
  new Promise((done) => {
    const socket = createSocket().listen(0, "127.0.0.1", () => {
      const { port } = socket.address();
      socket.close(() => done(port));
    });
  });

const encode = (value) => Buffer.from(JSON.stringify(value)).toString("base64url");

/** Returns the message by which the platform says who launches qdot; a teacher who is editing the course chooses. */
function sign(nonce, user) {
  const now = Math.floor(Date.now() / 1000);
  const isEditing = user === "editor";
  const claims = {
    iss: platform,
    aud: "client",
    sub: user,
    name: user,
    email: `${user}@example.edu`,
    nonce,
    iat: now,
    exp: now + 300,
    [`${CLAIM}message_type`]: isEditing ? "LtiDeepLinkingRequest" : "LtiResourceLinkRequest",
    [`${CLAIM}version`]: "1.3.0",
    [`${CLAIM}deployment_id`]: "1",
    [`${CLAIM}target_link_uri`]: `${tool}/a/homework/`,
    [`${CLAIM}resource_link`]: { id: "1" },
    [`${CLAIM}roles`]: [`${ROLE}${user === "ada" ? "Learner" : "Instructor"}`],
    [`${CLAIM}context`]: { id: "1", title: "Robotics" },
    [`${DEEP_LINKING}deep_linking_settings`]: isEditing && {
      deep_link_return_url: `${platform}/chosen`,
      accept_types: ["ltiResourceLink"],
      accept_presentation_document_targets: ["iframe"],
    },
  };
  const text = `${encode({ alg: "RS256", kid: "1", typ: "JWT" })}.${encode(claims)}`;
  const signature = createSign("RSA-SHA256")
    .update(text)
    .sign(readFileSync(join(folder, "key.pem")), "base64url");
  return `${text}.${signature}`;
}

/** The storage that a platform offers to pages in its frames, as in "LTI Client Side postMessages". */
function answerMessages(origin) {
  const values = new Map();
  addEventListener("message", ({ data, origin: sender, source }) => {
    const { subject, message_id, key, value } = data;
    const send = (content) => source.postMessage({ subject: `${subject}.response`, message_id, ...content }, sender);
    const refuse = (code) => send({ error: { code, message: code } });
    if (sender !== origin) refuse("wrong_origin");
    else if (!message_id || typeof key !== "string") refuse("bad_request");
    else if (subject === "lti.get_data") send({ key, value: values.get(key) ?? null });
    else if (subject !== "lti.put_data") refuse("unsupported_subject");
    else if (location.hash === "#full") refuse("storage_exhaustion");
    else send({ key, value: (values.set(key, value), value) });
  });
}

/** The platform: a course page with qdot in a frame, the page that answers a login, and its public key. */
function answerAsPlatform({ url }, answer) {
  const { pathname, searchParams } = new URL(url, "https://localhost");
  if (pathname === "/keys") {
    const key = createPublicKey(createPrivateKey(readFileSync(join(folder, "key.pem")))).export({ format: "jwk" });
    return void answer.end(JSON.stringify({ keys: [{ ...key, kid: "1", alg: "RS256", use: "sig" }] }));
  }
  answer.setHeader("content-type", "text/html");
  if (pathname === "/chosen") return void answer.end("The course has a new activity.");
  if (pathname === "/storage") return void answer.end(`<script>(${answerMessages})("${tool}")</script>`);
  if (pathname === "/auth") {
    const fields = {
      state: searchParams.get("state"),
      id_token: sign(searchParams.get("nonce"), searchParams.get("login_hint")),
    };
    const inputs = Object.entries(fields).map(
      ([name, value]) => `<input type="hidden" name="${name}" value="${value}">`,
    );
    const form = `<form method="post" action="${searchParams.get("redirect_uri")}">${inputs.join("")}</form>`;
    return void answer.end(`${form}<script>document.forms[0].submit()</script>`);
  }
  const query = new URLSearchParams({
    ...{ iss: platform, login_hint: searchParams.get("user"), target_link_uri: `${tool}/`, client_id: "client" },
    ...(searchParams.has("storage") ? { lti_storage_target: "storage" } : {}),
  });
  answer.end(
    `<h1>Course</h1><iframe name="storage" hidden src="/storage#${searchParams.get("storage")}"></iframe>
    <script>onload = () => (document.querySelector("#tool").src = "${login}?${query}")</script>
    <iframe id="tool" width="900" height="600"></iframe>`,
  );
}

before(async () => {
  const names = "subjectAltName=DNS:localhost,IP:127.0.0.1";
  const [key, cert] = ["key.pem", "cert.pem"].map((name) => join(folder, name));
  const subject = ["-subj", "/CN=localhost", "-addext", names, "-days", "2"];
  execFileSync("openssl", ["req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", key, "-out", cert, ...subject], {
    stdio: "ignore",
  });
  const port = await findFreePort();
  tool = `https://127.0.0.1:${await serve((incoming, answer) => {
    const headers = { ...incoming.headers, "x-forwarded-proto": "https" };
    const onward = request({ port, method: incoming.method, path: incoming.url, headers }, (reply) => {
      const { "set-cookie": cookies, ...others } = reply.headers;
      answer.writeHead(reply.statusCode, cookies && hasCookies ? reply.headers : others);
      reply.pipe(answer);
    });
    onward.on("error", () => answer.writeHead(502).end());
    incoming.pipe(onward);
  })}`;
  platform = `https://localhost:${await serve(answerAsPlatform)}`;
  const homework = join(folder, "homework");
  mkdirSync(homework);
  const assignment = `title = "Homework"
key = "homework"
practice = true
[[problem]]
family = "planar-2r"
questions = ["determinant", "joint-effect"]
`;
  const roster = "student,name,email\ns001,Ada,ada@example.edu\n";
  const files = { "assignment.toml": assignment, "roster.csv": roster, "secret.txt": "0123456789abcdef\n" };
  for (const [name, text] of Object.entries(files)) writeFileSync(join(homework, name), text);
  const common = [homework, "--url", tool];
  const register = ["serve", "register", ...common, "--platform", "moodle", "--site", platform];
  login = /https:\/\/\S+\/lti\/login\/\S+/.exec(execFileSync(QDOT, register, { encoding: "utf8" }))[0];
  const paths = ["auth", "token", "keys"].flatMap((name) => [`--${name}-url`, `${platform}/${name}`]);
  execFileSync(QDOT, [...register, "--client-id", "client", ...paths]);
  const env = { ...process.env, REQUESTS_CA_BUNDLE: cert };
  service = spawn(QDOT, ["serve", ...common, "--port", String(port)], { env, stdio: ["ignore", "pipe", "inherit"] });
  await new Promise((done) => service.stdout.once("data", done));
});

after(async () => {
  const end = service && once(service, "exit");
  service?.kill();
  await end;
  servers.forEach((server) => (server.close(), server.closeAllConnections()));
  rmSync(folder, { recursive: true, force: true });
});

/** Settings of browsers: the usual ones; without third-party cookies; without any cookies of qdot in the frame. */
const ALL = () => ({ cookie_controls_mode: 0 });
const FIRST_PARTY = () => ({ cookie_controls_mode: 1, block_third_party_cookies: true });
const NONE_IN_FRAME = () => ({
  content_settings: { exceptions: { cookies: { [`${tool},${platform}`]: { setting: 2 } } } },
});

/** Opens the course in a new browser; `storage` says what storage the platform has. */
async function openCourse(settings, user, storage, script) {
  const { chromium } = await import("playwright-core");
  const profile = mkdtempSync(join(folder, "profile-"));
  mkdirSync(join(profile, "Default"));
  writeFileSync(join(profile, "Default", "Preferences"), JSON.stringify({ profile: settings() }));
  const context = await chromium.launchPersistentContext(profile, {
    executablePath: CHROMIUM,
    args: ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"],
    ignoreHTTPSErrors: true,
    locale: "en-GB",
  });
  contexts.push(context);
  context.setDefaultTimeout(PATIENCE);
  if (script) await context.addInitScript(script);
  const requested = [];
  context.on("request", (request) => requested.push(request));
  const page = await context.newPage();
  await page.goto(`${platform}/?${new URLSearchParams({ user, ...(storage ? { storage } : {}) })}`);
  return { context, page, inside: page.frameLocator("#tool"), requested, frame: () => page.frames().at(-1) };
}
const contexts = [];
afterEach(() => Promise.all(contexts.splice(0).map((context) => context.close())));

const showsClass = ({ inside }) => inside.getByText("Students with a submission").waitFor();

for (const [title, settings, storage] of [
  ["in a browser with the usual settings", ALL, undefined],
  ["in one that blocks third-party cookies", FIRST_PARTY, undefined],
  ["in one that stores no cookies in the frame", NONE_IN_FRAME, "yes"],
])
  test(`a teacher reads the class in the platform's frame, ${title}`, async () => {
    const course = await openCourse(settings, "grace", storage);
    await showsClass(course);
    assert.equal(new URL(course.frame().url()).pathname, "/a/homework/class/");
    const cookies = (await course.context.cookies()).filter(({ name }) => name === "__Host-sessionid");
    assert.equal(cookies.filter(({ partitionKey }) => partitionKey).length, settings === NONE_IN_FRAME ? 0 : 1);
  });

for (const storage of [undefined, "full"])
  test(`without cookies and ${storage ?? "any"} storage, a button opens a new tab in which the teacher is signed in`, async () => {
    const { context, inside, frame } = await openCourse(NONE_IN_FRAME, "grace", storage);
    const button = inside.getByText("Open qdot in a new tab");
    await button.waitFor();
    const [tab] = await Promise.all([context.waitForEvent("page"), button.click()]);
    await tab.getByText("Students with a submission").waitFor();
    assert.equal(new URL(tab.url()).pathname, "/a/homework/class/");
    assert.equal(new URL(frame().url()).pathname.startsWith("/lti/login/"), true);
  });

/** Asserts that no address, and no Referer, contains the key of a session in pages. */
async function assertSecret({ requested, frame }) {
  const key = await frame().evaluate(() => document.querySelector("#session [name=session]").value);
  assert.ok(key.length > 20);
  for (const request of requested) {
    const { referer = "" } = await request.allHeaders();
    assert.ok(!`${request.url()} ${referer}`.includes(key), request.url());
  }
}

test("a student without cookies answers, takes the notebook away, practises, and comes back", async () => {
  const course = await openCourse(NONE_IN_FRAME, "ada", "yes");
  const { page, inside } = course;
  await inside.getByLabel("Your answer").fill("a1*a2*sin(theta2)");
  await submit(inside);
  await inside.locator(".verdict").waitFor();
  await inside.getByText("Work in a notebook").click();
  const [download] = await Promise.all([
    page.waitForEvent("download"),
    inside.getByRole("link", { name: "Download your notebook" }).click(),
  ]);
  assert.equal(download.suggestedFilename(), "homework.ipynb");
  await inside.getByRole("link", { name: "Practise on other problems" }).click();
  await inside.getByRole("link", { name: "Back to the assignment" }).click();
  await inside.locator(".verdict").waitFor();
  await assertSecret(course);
});

test("a teacher without cookies chooses a question for the course", async () => {
  const course = await openCourse(NONE_IN_FRAME, "editor", "yes");
  await course.inside.getByRole("button", { name: "Add to the course" }).click();
  await course.inside.getByText("The course has a new activity.").waitFor();
});

test("Back and a reload keep the session in a browser that stores no cookies, but values of a tab", async () => {
  hasCookies = false;
  const course = await openCourse(ALL, "ada", "yes", () =>
    Object.defineProperty(document, "cookie", { get: () => "", set: () => undefined }),
  );
  const { page, inside, frame } = course;
  await inside.locator(".verdict").waitFor();
  await inside.getByRole("button", { name: "Next question" }).click();
  await inside.locator('[data-item="p1.joint-effect"]').waitFor();
  await inside.getByText("Work in a notebook").click();
  await inside.getByRole("link", { name: "Feedback on all of your work" }).click();
  await inside.getByRole("heading", { name: "Homework" }).waitFor();
  await page.evaluate(() => window.history.back());
  await inside.locator('[data-item="p1.joint-effect"]').waitFor();
  const answered = page.waitForResponse((response) => response.url().includes("/work?"));
  await frame().evaluate(() => window.location.reload());
  await answered;
  await inside.locator('[data-item="p1.joint-effect"]').waitFor();
  await assertSecret(course);
  hasCookies = true;
});
