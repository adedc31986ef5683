// A learning platform on another site shows qdot in a frame: with the browser's usual settings, and in a browser that
// blocks third-party cookies, where a button opens a new tab instead. Both servers speak HTTPS, as browsers demand it.
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
import { after, before, test } from "node:test";

import { CHROMIUM } from "../tools/browser.mjs";

const QDOT = process.env.QDOT ?? "qdot";
const CLAIM = "https://purl.imsglobal.org/spec/lti/claim/";
const INSTRUCTOR = "http://purl.imsglobal.org/vocab/lis/v2/membership#Instructor";
const folder = mkdtempSync(join(tmpdir(), "qdot-lti-"));
const servers = [];
let service, platform, tool, login;

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

/** Returns the message by which the platform says who launches qdot. */
function sign(nonce) {
  const now = Math.floor(Date.now() / 1000);
  const claims = {
    iss: platform,
    aud: "client",
    sub: "grace",
    name: "Grace",
    nonce,
    iat: now,
    exp: now + 300,
    [`${CLAIM}message_type`]: "LtiResourceLinkRequest",
    [`${CLAIM}version`]: "1.3.0",
    [`${CLAIM}deployment_id`]: "1",
    [`${CLAIM}target_link_uri`]: `${tool}/a/homework/`,
    [`${CLAIM}resource_link`]: { id: "1" },
    [`${CLAIM}roles`]: [INSTRUCTOR],
    [`${CLAIM}context`]: { id: "1", title: "Robotics" },
  };
  const text = `${encode({ alg: "RS256", kid: "1", typ: "JWT" })}.${encode(claims)}`;
  const signature = createSign("RSA-SHA256")
    .update(text)
    .sign(readFileSync(join(folder, "key.pem")), "base64url");
  return `${text}.${signature}`;
}

/** The platform: a course page with qdot in a frame, the page that answers a login, and its public key. */
function answerAsPlatform({ url }, answer) {
  const { pathname, searchParams } = new URL(url, "https://localhost");
  if (pathname === "/keys") {
    const key = createPublicKey(createPrivateKey(readFileSync(join(folder, "key.pem")))).export({ format: "jwk" });
    return void answer.end(JSON.stringify({ keys: [{ ...key, kid: "1", alg: "RS256", use: "sig" }] }));
  }
  answer.setHeader("content-type", "text/html");
  if (pathname === "/auth") {
    const fields = { state: searchParams.get("state"), id_token: sign(searchParams.get("nonce")) };
    const inputs = Object.entries(fields).map(
      ([name, value]) => `<input type="hidden" name="${name}" value="${value}">`,
    );
    const form = `<form method="post" action="${searchParams.get("redirect_uri")}">${inputs.join("")}</form>`;
    return void answer.end(`${form}<script>document.forms[0].submit()</script>`);
  }
  const query = new URLSearchParams({
    iss: platform,
    login_hint: "7",
    target_link_uri: `${tool}/`,
    client_id: "client",
  });
  answer.end(`<h1>Course</h1><iframe width="900" height="600" src="${login}?${query}"></iframe>`);
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
      answer.writeHead(reply.statusCode, reply.headers);
      reply.pipe(answer);
    });
    onward.on("error", () => answer.writeHead(502).end());
    incoming.pipe(onward);
  })}`;
  platform = `https://localhost:${await serve(answerAsPlatform)}`;
  const homework = join(folder, "homework");
  mkdirSync(homework);
  const problem =
    'title = "Homework"\nkey = "homework"\n[[problem]]\nfamily = "planar-2r"\nquestions = ["determinant"]\n';
  const files = { "assignment.toml": problem, "roster.csv": "student\ns001\n", "secret.txt": "0123456789abcdef\n" };
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

/** Opens the course in a new browser, whose settings say which cookies it blocks (1: of third parties). */
async function openCourse(cookieMode) {
  const { chromium } = await import("playwright-core");
  const profile = mkdtempSync(join(folder, "profile-"));
  mkdirSync(join(profile, "Default"));
  const preferences = { profile: { cookie_controls_mode: cookieMode, block_third_party_cookies: cookieMode === 1 } };
  writeFileSync(join(profile, "Default", "Preferences"), JSON.stringify(preferences));
  const context = await chromium.launchPersistentContext(profile, {
    executablePath: CHROMIUM,
    args: ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"],
    ignoreHTTPSErrors: true,
  });
  const page = await context.newPage();
  await page.goto(platform);
  return { context, page };
}

test("a teacher reads the class in the platform's frame", async () => {
  const { context, page } = await openCourse(0);
  await page.frameLocator("iframe").getByText("Students with a submission").waitFor();
  assert.equal(new URL(page.frames()[1].url()).pathname, "/a/homework/class/");
  await context.close();
});

test("if the browser blocks cookies in frames, a button opens a new tab in which the teacher is signed in", async () => {
  const { context, page } = await openCourse(1);
  const button = page.frameLocator("iframe").getByText("Open qdot in a new tab");
  await button.waitFor();
  const [tab] = await Promise.all([context.waitForEvent("page"), button.click()]);
  await tab.getByText("Students with a submission").waitFor();
  assert.equal(new URL(tab.url()).pathname, "/a/homework/class/");
  assert.equal(new URL(page.frames()[1].url()).pathname.startsWith("/lti/login/"), true);
  await context.close();
});
