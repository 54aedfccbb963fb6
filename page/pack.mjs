// Writes the folder of the page: the files of www, and the WebAssembly module as text in a script, because pages that are
// opened from disk may not read other files. Usage: node pack.mjs MODULE FOLDER
import { copyFileSync, mkdirSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const [, , module, folder] = process.argv;
const www = join(dirname(fileURLToPath(import.meta.url)), "www");
rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });
for (const name of readdirSync(www)) copyFileSync(join(www, name), join(folder, name));
writeFileSync(join(folder, "module.js"), `"use strict";\nconst MODULE = "${readFileSync(module).toString("base64")}";\n`);
for (const name of readdirSync(folder)) console.log(`${name}: ${statSync(join(folder, name)).size} bytes`);
