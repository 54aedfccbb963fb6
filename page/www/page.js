"use strict";
// Draws what the module answers. The module knows the protocols, this script does not.

const $ = (id) => document.getElementById(id);
const MOST_ROWS = 2000;

function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

function say(error) {
  $("error").textContent = error ?? "";
  $("error").hidden = !error;
}

let exports;

// Sends a request, with the bytes of a file after it, and returns the answer.
function call(request, body = new Uint8Array()) {
  try {
    const head = new TextEncoder().encode(JSON.stringify(request) + "\n");
    const at = exports.room(head.length + body.length) >>> 0;
    const room = new Uint8Array(exports.memory.buffer, at, head.length + body.length);
    room.set(head);
    room.set(body, head.length);
    const length = exports.call() >>> 0;
    const text = new Uint8Array(exports.memory.buffer, exports.answer() >>> 0, length);
    return JSON.parse(new TextDecoder().decode(text));
  } catch (error) {
    return { error: `the page failed: ${error.message}: load it again` };
  }
}

// Rows of the table

let rows = [];

function rowElement(row) {
  const message = make("td", {}, make("b", {}, row.title));
  if (row.subtitle) message.append(" ", row.subtitle);
  const fields = make("td");
  for (const [name, text] of row.fields) {
    fields.append(make("span", { class: "field" }, make("span", { class: "name" }, name), " ", text));
  }
  for (const [severity, text] of row.notes) {
    fields.append(make("span", { class: `note ${severity}` }, `${severity}: ${text}`));
  }
  const element = make("tr", { class: `${row.from} ${row.mark}` },
    make("td", { title: `byte ${row.offset}, ${row.len} bytes` }, String(row.number)),
    make("td", {}, row.from === "host" ? "host →" : "← device"), message, fields);
  return element;
}

function passes(row) {
  const words = $("filter").value.toLowerCase();
  if ($("only-errors").checked && !row.mark) return false;
  if (!words) return true;
  row.text ??= JSON.stringify([row.from, row.title, row.subtitle, row.fields, row.notes]).toLowerCase();
  return row.text.includes(words);
}

function drawRows() {
  const body = $("messages").tBodies[0];
  body.replaceChildren(...rows.filter(passes).map(rowElement));
  $("messages").parentElement.scrollTop = 0;
}

function addRows(more) {
  const body = $("messages").tBodies[0];
  const scroll = body.closest(".scroll");
  const follows = scroll.scrollTop + scroll.clientHeight > scroll.scrollHeight - 30;
  rows.push(...more);
  body.append(...more.filter(passes).map(rowElement));
  if (rows.length > MOST_ROWS) {
    rows.splice(0, rows.length - MOST_ROWS);
    body.replaceChildren(...rows.filter(passes).map(rowElement));
  }
  if (follows) scroll.scrollTop = scroll.scrollHeight;
}

// Inspector

function inspect(bytes) {
  const choice = (id) => $(id).value || undefined;
  const request = { call: "inspect", protocol: choice("protocol"), from: choice("from"), transport: choice("transport") };
  const answer = call(request, bytes);
  say(answer.error);
  if (!answer.rows) return;
  live = false;
  rows = answer.rows;
  drawRows();
  const found = answer.detected ? "found: " : "";
  const shown = answer.count > rows.length ? `, the first ${rows.length} are shown` : "";
  $("summary").textContent = `${found}${answer.protocol}, ${answer.count} messages${shown}, ${answer.bad} with errors`;
}

// Move

const SVG = "http://www.w3.org/2000/svg";
function svg(tag, attributes, text) {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  if (text !== undefined) element.textContent = text;
  return element;
}

const short = (value) => String(Number(value.toPrecision(4))).replace("-", "−");

function figure(axis, duration) {
  const [width, left, right, height, gap] = [Math.max(360, Math.min(1000, $("move").clientWidth || 800)), 64, 8, 120, 34];
  const total = axis.panels.length * (height + gap) + 22;
  const drawing = svg("svg", { viewBox: `0 0 ${width} ${total}`, role: "img", "aria-label": `${axis.name}: position, velocity, acceleration over time` });
  const x = (time) => left + (width - left - right) * time / duration;
  axis.panels.forEach((panel, index) => {
    const top = index * (height + gap) + 22;
    const y = (value) => top + height * (panel.high - value) / (panel.high - panel.low);
    const line = (from, to, value, kind) => drawing.append(svg("line", { x1: from, x2: to, y1: y(value), y2: y(value), class: kind }));
    const inside = (value) => value >= panel.low && value <= panel.high;
    drawing.append(svg("text", { x: left, y: top - 7 }, `${panel.title}, ${panel.unit}`));
    drawing.append(svg("rect", { x: left, y: top, width: width - left - right, height, class: "frame" }));
    for (const [time] of axis.keys) drawing.append(svg("line", { x1: x(time), x2: x(time), y1: top, y2: top + height, class: "key" }));
    if (inside(0)) line(left, width - right, 0, "zero");
    for (const value of [panel.high, panel.low]) {
      drawing.append(svg("text", { x: left - 6, y: y(value) + (value === panel.high ? 11 : 0), "text-anchor": "end" }, short(value)));
    }
    if (panel.limit !== null) {
      for (const value of [panel.limit, -panel.limit].filter(inside)) line(left, width - right, value, "limit");
      drawing.append(svg("text", { x: width - right, y: top - 7, "text-anchor": "end", class: "limit-text" }, `limit ${short(panel.limit)}`));
    }
    const draw = (lines, kind) => lines.forEach((points) => drawing.append(svg("polyline", {
      class: kind, points: points.map(([time, value]) => `${x(time).toFixed(1)},${y(Math.min(panel.high, Math.max(panel.low, value))).toFixed(1)}`).join(" "),
    })));
    draw(panel.lines, "curve");
    draw(panel.beyond, "beyond");
    if (index === 0) for (const [time, value] of axis.keys) drawing.append(svg("circle", { cx: x(time), cy: y(value), r: 4, class: "dot" }));
  });
  drawing.append(svg("text", { x: left, y: total - 2 }, "0 s"));
  drawing.append(svg("text", { x: width - right, y: total - 2, "text-anchor": "end" }, `${short(duration)} s`));
  return make("figure", {}, make("h3", {}, axis.name), drawing);
}

function list(lines, kind) {
  return lines.map((line) => make("li", { class: kind }, line));
}

function showMove(name, bytes) {
  const answer = call({ call: "curves", name }, bytes);
  say(answer.error);
  if (!answer.axes) return;
  shown = answer;
  drawMove();
}

let shown;

function drawMove() {
  const answer = shown;
  const parts = [make("h3", {}, answer.name), make("p", { class: "quiet" }, answer.about)];
  if (answer.excesses.length) parts.push(make("ul", { class: "excesses" }, ...list(answer.excesses, "excess")));
  parts.push(...answer.axes.map((axis) => figure(axis, answer.duration)));
  parts.push(make("h3", {}, "Where each rig departs from the move"));
  const rigs = make("div", { class: "rigs" });
  for (const rig of answer.rigs) {
    const lines = rig.error ? list([rig.error], "excess") : [...list(rig.losses, "loss"), ...list(rig.excesses, "excess")];
    rigs.append(make("div", {}, make("b", {}, rig.name), make("ul", {}, ...lines)));
  }
  $("move").replaceChildren(...parts, rigs);
}

let width = innerWidth;
addEventListener("resize", () => {
  if (shown && width !== innerWidth) drawMove();
  width = innerWidth;
});

// Files

async function open(file) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  if (file.name.toLowerCase().endsWith(".json")) showMove(file.name, bytes);
  else inspect(bytes);
}

for (const id of ["file", "move-file"]) {
  $(id).addEventListener("change", () => {
    const [file] = $(id).files;
    if (file) (id === "move-file" ? file.arrayBuffer().then((bytes) => showMove(file.name, new Uint8Array(bytes))) : open(file)).catch((error) => say(`the file cannot be read: ${error.message}`));
    $(id).value = "";
  });
}
addEventListener("dragover", (event) => { event.preventDefault(); document.body.classList.add("over"); });
addEventListener("dragleave", () => document.body.classList.remove("over"));
addEventListener("drop", (event) => {
  event.preventDefault();
  document.body.classList.remove("over");
  const [file] = event.dataTransfer.files;
  if (file) open(file).catch((error) => say(`the file cannot be read: ${error.message}`));
});

// Simulated rig

let devices = [];
let on = false;
let live = false;
let held = null;
let last = 0;

function show(report) {
  if (report.error) return say(report.error);
  on = report.on;
  $("connect").disabled = !on || report.ready;
  if (!on) { $("state").textContent = report.stop; return; }
  const state = report.ready ? "connected" : "not connected";
  $("state").textContent = `${(report.time / 1000).toFixed(1)} s: ${state}${report.stop ? `; ${report.stop}` : ""}`;
  drawMotors(report);
  for (const { time, line } of report.notes) $("notes").append(make("li", {}, `${(time / 1000).toFixed(1)} s: ${line}`));
  while ($("notes").children.length > 200) $("notes").firstChild.remove();
  if (report.notes.length) { $("notes").hidden = false; $("notes").scrollTop = $("notes").scrollHeight; }
  if (live && report.rows.length) {
    addRows(report.rows);
    $("summary").textContent = `${$("rig-protocol").value}, live: ${report.count} messages`;
  }
}

function drawMotors(report) {
  const all = $("motors");
  if (all.children.length !== report.motors.length) {
    all.replaceChildren(...report.motors.map(({ number }) => {
      const jog = (forward, name) => {
        const button = make("button", { type: "button", "aria-label": `jog motor ${number} ${forward ? "forward" : "backward"}, while held` }, name);
        const hold = (event) => { if (event.key === undefined || event.key === " " || event.key === "Enter") { event.preventDefault(); held = { motor: number, forward }; } };
        button.addEventListener("pointerdown", hold);
        button.addEventListener("keydown", hold);
        for (const end of ["pointerup", "pointerleave", "pointercancel", "keyup", "blur"]) button.addEventListener(end, () => { held = null; });
        return button;
      };
      const go = make("button", { type: "button", "aria-label": `move motor ${number} a short way` }, "Move");
      go.addEventListener("click", () => show(call({ call: "go", motor: number })));
      return make("div", { class: "motor" }, make("span", {}, `Motor ${number}`), make("span", { class: "bar", "aria-hidden": "true" }, make("i")),
        make("span", { class: "number" }), make("span", { class: "buttons" }, jog(false, "◀ Jog"), jog(true, "Jog ▶"), go));
    }));
  }
  report.motors.forEach((motor, index) => {
    const [, bar, number, buttons] = all.children[index].children;
    bar.firstChild.style.left = `${100 * (motor.position - motor.low) / (motor.high - motor.low)}%`;
    number.textContent = `${motor.position.toFixed(1)} ${report.unit}`;
    for (const button of buttons.children) button.disabled = !report.ready;
  });
}

function tick(now) {
  const millis = Math.round(Math.min(200, now - last));
  if (on && millis >= 15) {
    last = now;
    show(call({ call: "advance", millis, held }));
  } else if (!on) {
    last = now;
  }
  requestAnimationFrame(tick);
}

function chooseProtocol() {
  const chosen = devices.find(({ protocol }) => protocol === $("rig-protocol").value);
  $("rig-device").replaceChildren(...chosen.devices.map(({ name }) => make("option", { value: name }, name)));
  chooseDevice();
}

function chooseDevice() {
  const chosen = devices.find(({ protocol }) => protocol === $("rig-protocol").value);
  $("about").textContent = chosen.devices.find(({ name }) => name === $("rig-device").value)?.about ?? "";
}

function start() {
  held = null;
  const report = call({ call: "start", protocol: $("rig-protocol").value, device: $("rig-device").value });
  if (report.error) return say(report.error);
  say();
  live = true;
  rows = [];
  drawRows();
  $("summary").textContent = "No messages yet: connect to the rig.";
  $("motors").replaceChildren();
  $("notes").replaceChildren();
  $("notes").hidden = true;
  show(report);
}

$("stop").addEventListener("click", () => { held = null; show(call({ call: "stop" })); });
$("start").addEventListener("click", start);
$("connect").addEventListener("click", () => show(call({ call: "connect" })));
$("rig-protocol").addEventListener("change", chooseProtocol);
$("rig-device").addEventListener("change", chooseDevice);
$("inspect").addEventListener("click", () => inspect(new TextEncoder().encode($("capture").value)));
$("capture").addEventListener("paste", () => setTimeout(() => inspect(new TextEncoder().encode($("capture").value))));
$("filter").addEventListener("input", drawRows);
$("only-errors").addEventListener("change", drawRows);
addEventListener("blur", () => { held = null; });
document.addEventListener("visibilitychange", () => { held = null; });

WebAssembly.instantiate(Uint8Array.from(atob(MODULE), (letter) => letter.charCodeAt(0)), {}).then(({ instance }) => {
  exports = instance.exports;
  devices = call({ call: "devices" });
  $("rig-protocol").replaceChildren(...devices.map(({ protocol, name }) => make("option", { value: protocol }, name)));
  chooseProtocol();
  document.body.dataset.ready = "yes";
  requestAnimationFrame(tick);
}).catch((error) => say(`this browser cannot run the page: ${error.message}`));
