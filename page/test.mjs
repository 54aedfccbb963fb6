// Tries the page in a browser without a screen, opened from disk. It drives the browser by its own protocol, over a pipe.
// Usage: node test.mjs FOLDER [PICTURES]
import { spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

const [, , folder, pictures] = process.argv;
const examples = join(dirname(fileURLToPath(import.meta.url)), "../examples");
const profile = mkdtempSync(join(tmpdir(), "page-"));
const browser = spawn("chromium-headless-shell", ["--no-sandbox", "--disable-gpu", "--remote-debugging-pipe",
  `--user-data-dir=${profile}`, "about:blank"], { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
const limit = setTimeout(() => { console.error("failed: the browser took more than 80 s"); browser.kill(); process.exit(1); }, 80_000);

// The protocol of the browser: JSON, each message with a zero byte at its end.
let next = 1, session, input = "";
const waiting = new Map();
const requested = [], thrown = [];
browser.on("error", (error) => { console.error(`failed: ${error.message}`); process.exit(1); });
browser.stdio[4].on("data", (data) => {
  input += data;
  for (let end; (end = input.indexOf("\0")) >= 0; input = input.slice(end + 1)) {
    const message = JSON.parse(input.slice(0, end));
    if (message.method === "Network.requestWillBeSent") requested.push(message.params.request.url);
    if (message.method === "Runtime.exceptionThrown") thrown.push(message.params.exceptionDetails.exception?.description ?? message.params.exceptionDetails.text);
    const done = waiting.get(message.id);
    waiting.delete(message.id);
    if (done) message.error ? done.reject(new Error(message.error.message)) : done.resolve(message.result);
  }
});
function send(method, params = {}) {
  return new Promise((resolve, reject) => {
    waiting.set(next, { resolve, reject });
    browser.stdio[3].write(JSON.stringify({ id: next++, method, params, sessionId: session }) + "\0");
  });
}

async function run(expression) {
  const { result, exceptionDetails } = await send("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true });
  if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
  return result.value;
}
const pause = (millis) => new Promise((done) => setTimeout(done, millis));
async function until(expression, what) {
  for (let tries = 0; tries < 200; tries++) {
    if (await run(`Boolean(${expression})`)) return;
    await pause(50);
  }
  throw new Error(`${what}: not within 10 s; error line: ${await run("$('error').textContent")}; state: ${await run("$('state').textContent")}`);
}
let checks = 0;
function check(is, what) {
  if (!is) throw new Error(what);
  checks++;
}
const text = (id) => run(`$("${id}").textContent`);
const count = (selector) => run(`document.querySelectorAll(${JSON.stringify(selector)}).length`);

async function click(id) {
  await run(`$("${id}").scrollIntoView({ block: "center" })`);
  const at = await run(`(({ x, y, width, height }) => ({ x: x + width / 2, y: y + height / 2 }))($("${id}").getBoundingClientRect())`);
  for (const type of ["mousePressed", "mouseReleased"]) await send("Input.dispatchMouseEvent", { type, ...at, button: "left", clickCount: 1 });
}
const paste = async (capture) => {
  await run(`$("capture").value = ""; $("capture").focus()`);
  await send("Input.insertText", { text: capture });
  await click("inspect");
};
const drop = (name, bytes) => run(`(async () => {
  const data = new DataTransfer();
  data.items.add(new File([Uint8Array.from(atob("${Buffer.from(bytes).toString("base64")}"), (letter) => letter.charCodeAt(0))], ${JSON.stringify(name)}));
  document.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
})()`);
const key = (type) => send("Input.dispatchKeyEvent", { type, key: " ", code: "Space", windowsVirtualKeyCode: 32, text: type === "keyDown" ? " " : undefined });
const position = () => run(`parseFloat(document.querySelector(".motor .number").textContent)`);

async function picture(name, width, dark) {
  await send("Emulation.setDeviceMetricsOverride", { width, height: 900, deviceScaleFactor: 1, mobile: false });
  await send("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value: dark ? "dark" : "light" }] });
  check(await run("document.documentElement.scrollWidth <= innerWidth"), `the page is wider than ${width} pixels`);
  if (!pictures) return;
  mkdirSync(pictures, { recursive: true });
  const { data } = await send("Page.captureScreenshot", { captureBeyondViewport: true, format: "png" });
  writeFileSync(join(pictures, `${name}.png`), Buffer.from(data, "base64"));
}

async function test() {
  const { targetId } = await send("Target.createTarget", { url: "about:blank" });
  ({ sessionId: session } = await send("Target.attachToTarget", { targetId, flatten: true }));
  for (const domain of ["Page", "Runtime", "Network"]) await send(`${domain}.enable`);
  await send("Emulation.setDeviceMetricsOverride", { width: 1280, height: 900, deviceScaleFactor: 1, mobile: false });
  await send("Page.navigate", { url: pathToFileURL(resolve(folder, "index.html")).href });
  await until(`document.readyState === "complete" && typeof $ === "function" && document.body.dataset.ready === "yes"`, "the page is ready");

  // STOP is there before everything else.
  await click("stop");
  check((await text("state")).includes("nothing moves"), "STOP without a rig says that nothing moves");

  for (const [file, protocol] of [["kos.txt", "kos"], ["dmc.txt", "dmc"], ["hoot.txt", "hoot"], ["dmc-move.txt", "dmc"]]) {
    await paste(readFileSync(join(examples, "captures", file), "utf8"));
    check((await text("summary")).startsWith(`found: ${protocol}, `), `the protocol of ${file}: ${await text("summary")}`);
    check(await run(`$("error").hidden`), `no error in ${file}`);
    check(await count("#messages tr.host") > 2 && await count("#messages tr.device") > 2, `both directions of ${file}`);
  }
  await paste(readFileSync(join(examples, "captures/dmc.txt"), "utf8"));
  check(await count("#messages tr.error .note.error") > 0, "errors are marked");
  const all = await count("#messages tbody tr");
  await run(`$("filter").value = "jog"; $("filter").dispatchEvent(new Event("input"))`);
  const jogs = await count("#messages tbody tr");
  check(jogs > 0 && jogs < all && (await run(`[...document.querySelectorAll("#messages tbody tr")].every((row) => row.textContent.toLowerCase().includes("jog"))`)), "the filter");
  await run(`$("filter").value = ""; $("only-errors").click()`);
  check(await count("#messages tbody tr:not(.error, .warning)") === 0, "only errors");
  await run(`$("only-errors").click()`);

  // Bad input is one line, and nothing is lost.
  for (const [bad, why] of [["> 0a 1\n", "single hex digit"], ["> 04 00 06 00 0b 01 xyz", "is not a hex digit"], ["04 00", "choose the sender"]]) {
    await paste(bad);
    const line = await text("error");
    check(line.includes(why) && !line.includes("\n"), `the line for ${bad}: ${line}`);
    check(await run(`$("capture").value`) === bad, "the text is still there");
    check(await count("#messages tbody tr") > 0, "the rows are still there");
  }

  await drop("crane.json", readFileSync(join(examples, "moves/crane.json")));
  await until(`document.querySelectorAll("#move svg").length > 0`, "a move is drawn");
  check(await count("#move svg polyline.curve") >= 3 && await count("#move svg .limit") > 0, "curves and limits");
  check(await count("#move .rigs > div") === 3 && await count("#move .rigs li") > 2, "where each rig departs");
  check(await run(`$("error").hidden`), `no error: ${await text("error")}`);
  await drop("broken.json", Buffer.from("{ \"move\": 1"));
  await until(`!$("error").hidden`, "a broken move is an error");
  check((await text("error")).includes("broken.json") && await count("#move svg") > 0, `the drawing is still there: ${await text("error")}`);
  await drop("whip.json", readFileSync(join(examples, "moves/whip.json")));
  await until(`document.querySelectorAll("#move svg .beyond").length > 0`, "an excess is drawn");
  await drop("raw.bin", Buffer.from([0, 0, 0, 0, 0, 255, 3, 1, 4, 0]));
  await until(`$("error").textContent.includes("choose host or device")`, "raw bytes need a sender");
  await run(`$("from").value = "host"`);
  await drop("raw.bin", Buffer.from([0, 0, 0, 0, 0, 255, 3, 1, 4, 0]));
  await until(`$("messages").textContent.includes("MotorStop")`, "raw bytes are shown");
  await run(`$("from").value = ""`);

  for (const protocol of ["hoot", "dmc", "kos"]) {
    await run(`$("rig-protocol").value = "${protocol}"; $("rig-protocol").dispatchEvent(new Event("change"))`);
    check(await count("#rig-device option") > 1, `devices of ${protocol}`);
    await click("start");
    check((await text("state")).includes("not connected"), `${protocol} is on`);
    await click("connect");
    await until(`!$("state").textContent.includes("not connected")`, `${protocol} connects`);
    await until(`document.querySelector("#messages tr.host") && document.querySelector("#messages tr.device")`, `traffic of ${protocol}`);
    // The jog works with the keyboard: it lasts as long as the key is held.
    const before = await position();
    await run(`document.querySelectorAll(".motor button")[1].focus()`);
    await key("keyDown");
    await until(`parseFloat(document.querySelector(".motor .number").textContent) > ${before + 0.5}`, `a jog of ${protocol}`);
    await click("stop");
    await until(`$("state").textContent.includes("the rig confirmed the stop")`, `the stop of ${protocol}`);
    await pause(600);
    const [one, other] = [await position(), (await pause(300), await position())];
    check(one === other, `${protocol} rests after STOP, also while the key is held: ${one}, ${other}`);
    await key("keyUp");
    await pause(100);
    await run(`document.querySelectorAll(".motor button")[2].click()`);
    await until(`parseFloat(document.querySelector(".motor .number").textContent) > ${other + 0.5}`, `a short move of ${protocol}`);
    check(await run(`$("stop").disabled`) === false, "STOP is enabled");
  }

  await picture("wide-light", 1280, false);
  await picture("wide-dark", 1280, true);
  await picture("narrow-light", 420, false);
  const remote = requested.filter((url) => !/^(file|data):/.test(url));
  check(remote.length === 0, `no request leaves the computer: ${remote}`);
  check(thrown.length === 0, `no exception: ${thrown}`);
}

let status = 0;
try {
  await test();
  console.log(`ok: ${checks} checks in the browser`);
} catch (error) {
  console.error(`failed: ${error.message}`);
  status = 1;
}
clearTimeout(limit);
browser.kill();
await new Promise((done) => (browser.exitCode === null && browser.signalCode === null ? browser.on("exit", done) : done()));
rmSync(profile, { recursive: true, force: true, maxRetries: 5, retryDelay: 100 });
process.exit(status);
