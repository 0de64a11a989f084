// Build the page: `node build.mjs` writes ../bundle/{index.html,app.js,app.css,file.js} and the views.
// `--watch` builds again at every change; `--tests` compiles the tests of the pure modules.
import { copyFile, mkdir, readdir, rm } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import * as esbuild from "esbuild";

const here = fileURLToPath(new URL(".", import.meta.url));
const bundle = `${here}../bundle/`;

/** Options that the page and its tests share. */
const shared = { bundle: true, format: "esm", target: "es2022", logLevel: "warning" };

async function buildTests() {
  await rm(`${here}.tests`, { recursive: true, force: true });
  const files = (await readdir(`${here}test`)).filter((name) => name.endsWith(".test.ts"));
  await esbuild.build({
    ...shared,
    entryPoints: files.map((name) => `${here}test/${name}`),
    outdir: `${here}.tests`,
    outExtension: { ".js": ".mjs" },
    platform: "node",
  });
}

async function buildPage() {
  const watch = process.argv.includes("--watch");
  await mkdir(bundle, { recursive: true });
  for (const name of await readdir(bundle)) if (name.endsWith(".js")) await rm(`${bundle}${name}`);
  const options = {
    ...shared,
    outdir: bundle,
    minify: !watch,
    legalComments: "inline", // the licence of three.js travels with its code
  };
  const page = {
    ...options,
    entryPoints: [
      { in: `${here}src/app.ts`, out: "app" },
      { in: `${here}src/style/app.css`, out: "app" },
    ],
    splitting: true, // a view is loaded when it is opened
    chunkNames: "[name]-[hash]",
  };
  // A classic script, which runs inside a page opened from a disk.
  const file = { ...options, format: "iife", entryPoints: [{ in: `${here}src/file.ts`, out: "file" }] };
  await copyFile(`${here}src/index.html`, `${bundle}index.html`);
  for (const one of [page, file]) {
    if (watch) await (await esbuild.context(one)).watch();
    else await esbuild.build(one);
  }
}

await (process.argv.includes("--tests") ? buildTests() : buildPage());
