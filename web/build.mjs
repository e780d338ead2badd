// Bundles the page into the Python package: node build.mjs [FOLDER]
import { createHash } from "node:crypto";
import { mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, "../src/ecume/show/view/bundle");
mkdirSync(out, { recursive: true });

async function bundled(name) {
  const { outputFiles } = await build({
    entryPoints: [join(here, "src", name)],
    absWorkingDir: here,
    bundle: true,
    minify: true,
    format: "iife",
    target: "es2022",
    charset: "utf8",
    legalComments: "inline",
    write: false,
  });
  return outputFiles[0].text.replaceAll("</script", "<\\/script");
}

const source = (name) => readFileSync(join(here, "src", name), "utf8");

/** A page of a toy: its buttons and its main part, in the frame of all of them. */
function framed(name) {
  const [buttons, main] = source(name).split("---\n");
  return source("frame.html").replace("@BUTTONS@", () => buttons).replace("@MAIN@", () => main);
}

const plot = readFileSync(join(here, "node_modules/uplot/dist/uPlot.min.css"), "utf8");
const style = `${readFileSync(join(here, "src/style.css"), "utf8")}${plot.trim()}\n`;
const licence = (name) => readFileSync(join(here, "node_modules", name, "LICENSE"), "utf8");
const licences = [
  `uPlot (curves), bundled in view.js and view.css:\n\n${licence("uplot")}`,
  `uqr (QR codes), bundled in play.js:\n\n${licence("uqr")}`,
  readFileSync(join(here, "wasm/LICENSES.txt"), "utf8"),
];

// What the bundle was made of: where there is no npm, a test holds the sources to this.
const digest = createHash("sha256");
const sources = readdirSync(join(here, "src")).sort();
for (const name of [...sources.map((one) => `src/${one}`), "build.mjs", "package-lock.json", "wasm/LICENSES.txt"]) {
  digest.update(`${name}\n`).update(readFileSync(join(here, name)));
}

writeFileSync(join(out, "view.js"), await bundled("main.ts"));
for (const name of ["play", "tank", "t1", "all", "solver", "cluster", "pool"]) writeFileSync(join(out, `${name}.js`), await bundled(`${name}.ts`));
for (const name of ["play.html", "tank.html", "t1.html"]) writeFileSync(join(out, name), framed(name));
for (const name of ["play.css", "all.css", "all.html"]) writeFileSync(join(out, name), source(name));
writeFileSync(join(out, "view.css"), style);
writeFileSync(join(out, "page.html"), readFileSync(join(here, "src/page.html"), "utf8"));
writeFileSync(join(out, "LICENSES.txt"), licences.join("\n"));
writeFileSync(join(out, "SOURCES.sha256"), `${digest.digest("hex")}\n`);
