// A plant, as in docs/how-to/plant.md: PostgreSQL, two servers on it, and before them haproxy by
// deploy/haproxy.cfg, with TLS by a certificate of an authority of its own. The browser comes
// through the proxy alone; other clients use a server directly.

import assert from "node:assert/strict";
import { execFile, spawn } from "node:child_process";
import { createHash, X509Certificate } from "node:crypto";
import { existsSync, readdirSync } from "node:fs";
import { chown, mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import net from "node:net";
import { tmpdir } from "node:os";
import path from "node:path";
import { text } from "node:stream/consumers";
import { setTimeout as pause } from "node:timers/promises";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";
import { callOf, program, serve } from "../browser/harness.js";

/** @typedef {import("../browser/harness.js").Server} Server */
/** @typedef {import("../browser/harness.js").World["call"]} Call */
/** @typedef {"admin" | "engineer" | "operator" | "reader"} Role */
/** @typedef {0 | 1} Which of the servers */
/**
 * @typedef {object} Plant
 * @property {Server} server as clients see it: its address is the proxy's; starting it begins the servers that have ended
 * @property {readonly string[]} browser arguments of the browser, which trusts the authority and finds the host
 * @property {readonly [Server, Server]} servers
 * @property {(which: Which, role?: Role) => Call} at asks one of the servers, past the proxy
 * @property {Readonly<Record<Role, { id: string, key: string }>>} keys
 * @property {(which: Which) => Promise<void>} only sends what is new to one server
 * @property {() => Promise<void>} both sends it to both again
 * @property {(which: Which) => Promise<number>} requests that the proxy has with a server
 * @property {(which: Which, series: string) => Promise<number>} metric
 */

const run = promisify(execFile);
const configuration = fileURLToPath(new URL("../../../deploy/haproxy.cfg", import.meta.url));
/** A host name without DNS: the browser gets its address as an argument. */
const HOST = "plant.test";
/** The user of PostgreSQL, which does not run as root. */
const NOBODY = 65_534;
/** The longest wait. */
const PATIENCE_MS = Number(process.env["FLANKFIT_WAIT_MS"] ?? 30_000);
/** The line of the configuration that enables TLS. */
const BIND = /^ *bind "\$\{PLANT_LISTEN\}"$/m;
const NAMES = /** @type {const} */ (["one", "two"]);

/** Returns the path of a program. @param {string} name @param {readonly string[]} folders in addition to PATH */
function found(name, folders = []) {
  const all = [...(process.env["PATH"] ?? "").split(path.delimiter), ...folders];
  return all.map((folder) => path.join(folder, name)).find((file) => existsSync(file));
}

/** Returns the folder of PostgreSQL's programs, which Debian keeps out of the path. */
function postgres() {
  const versions = "/usr/lib/postgresql";
  const installed = existsSync(versions) ? readdirSync(versions).map((one) => path.join(versions, one, "bin")) : [];
  const named = process.env["FLANKFIT_POSTGRES_BIN"];
  const folders = named ? [named] : [...(process.env["PATH"] ?? "").split(path.delimiter), ...installed.reverse()];
  return folders.find((folder) => existsSync(path.join(folder, "initdb")));
}

const haproxy = () => found("haproxy", ["/usr/sbin", "/usr/local/sbin"]);

/** The reason for which this machine cannot run a plant. @returns {string | undefined} */
export function lacking() {
  const programs = { PostgreSQL: postgres(), haproxy: haproxy(), openssl: found("openssl") };
  const away = Object.entries(programs).flatMap(([name, place]) => (place ? [] : [name]));
  return away.length > 0 ? `there is no ${away.join(", no ")}` : undefined;
}

/**
 * Polls until a condition holds.
 * @template Value @param {string} what @param {() => Promise<Value>} look @param {(value: Value) => boolean} holds
 */
export async function until(what, look, holds) {
  const last = performance.now() + PATIENCE_MS;
  for (;;) {
    const value = await look();
    if (holds(value)) return value;
    assert.ok(performance.now() < last, `${what}: ${JSON.stringify(value)}`);
    await pause(20);
  }
}

/** Ports already returned. @type {Set<number>} */
const lookedAt = new Set();

/**
 * Returns a free port that the system gives to no client: a server must find it again after it was
 * killed. The plants of tests in Rust use other ones.
 */
async function freePort() {
  for (;;) {
    const port = 12_000 + Math.floor(Math.random() * 8_000);
    // several are searched at once, and each is free until somebody listens
    if (lookedAt.has(port)) continue;
    lookedAt.add(port);
    const free = await new Promise((resolve) => {
      const server = net.createServer().once("error", () => resolve(false));
      server.listen(port, "127.0.0.1", () => server.close(() => resolve(true)));
    });
    if (free) return port;
  }
}

const BEGIN = `"$BIN/initdb" -D data -A trust -U owner -E UTF8 --no-locale --no-sync >log
printf "listen_addresses=''\\nunix_socket_directories='$PWD'\\n" >>data/postgresql.conf
"$BIN/pg_ctl" -D data -l log -w start >>log && echo begun
cat; "$BIN/pg_ctl" -D data -m immediate -w stop >>log; rm -rf "$PWD"`;

/**
 * Starts a child of the shell whose script reads its input, which ends with this process, however
 * that ends.
 * @param {string} script @param {readonly string[]} args @param {import("node:child_process").SpawnOptions} options
 */
function keeper(script, args, options) {
  const child = spawn("/bin/sh", ["-c", script, ...args], { ...options, stdio: ["pipe", "pipe", "pipe"] });
  const [input, said] = [child.stdin, child.stdout];
  assert.ok(input && said && child.stderr);
  const ended = new Promise((resolve) => child.once("exit", resolve));
  const end = () => {
    input.end();
    return ended;
  };
  return { said, complaints: text(child.stderr), end };
}

/** Starts a database on a server of its own, on a Unix socket. */
async function database() {
  const folder = await mkdtemp(path.join(tmpdir(), "ff"));
  const root = process.getuid?.() === 0;
  if (root) await chown(folder, NOBODY, NOBODY);
  const env = { ...process.env, BIN: postgres() };
  const kept = keeper(BEGIN, [], { cwd: folder, env, ...(root ? { uid: NOBODY, gid: NOBODY } : {}) });
  const begun = await new Promise((resolve) => {
    kept.said.once("data", () => resolve(true)).once("end", () => resolve(false));
  });
  assert.ok(begun, `PostgreSQL does not start: ${await Promise.race([kept.complaints, ""])}`);
  return { url: `postgres://owner@localhost/postgres?host=${folder}`, end: kept.end };
}

/** Makes a certificate for the host, by an authority made for it alone. @param {string} folder */
async function certificate(folder) {
  const openssl = (/** @type {string} */ line) => run("openssl", line.split(" "), { cwd: folder });
  const newKey = "-newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes";
  await openssl(`req -x509 ${newKey} -keyout ca.key -out ca.pem -days 2 -subj /CN=authority-of-a-test`);
  await openssl(`req ${newKey} -keyout host.key -out host.csr -subj /CN=${HOST}`);
  await writeFile(path.join(folder, "names"), `subjectAltName=DNS:${HOST}\n`);
  await openssl("x509 -req -in host.csr -CA ca.pem -CAkey ca.key -CAcreateserial -days 2 -extfile names -out host.pem");
  const [authority, host, key] = await Promise.all(
    ["ca.pem", "host.pem", "host.key"].map((name) => readFile(path.join(folder, name))),
  );
  assert.ok(authority && host && key);
  const file = path.join(folder, "chain.pem");
  await writeFile(file, Buffer.concat([host, authority, key]));
  const publicKey = new X509Certificate(authority).publicKey.export({ type: "spki", format: "der" });
  return { file, trusted: createHash("sha256").update(publicKey).digest("base64") };
}

/**
 * Starts the proxy, which logs its actions.
 * @param {string} folder @param {number} port @param {readonly number[]} ports of the servers
 */
async function proxy(folder, port, ports) {
  const given = await readFile(configuration, "utf8");
  assert.match(given, BIND);
  const { file, trusted } = await certificate(folder);
  const [own, socket] = ["haproxy.cfg", "socket"].map((name) => path.join(folder, name));
  assert.ok(own && socket);
  // without the third server, at whose address another process could listen
  const withTls = given.replace(BIND, `$& ssl crt ${file} alpn h2,http/1.1`).replaceAll(/^ *server three .*$/gm, "");
  await writeFile(own, withTls.replace(/^global$/m, `$&\n    stats socket ${socket} level admin`));
  const [one, two] = ports.map((at) => `127.0.0.1:${at}`);
  const env = { ...process.env, PLANT_LISTEN: `127.0.0.1:${port}`, PLANT_ONE: one, PLANT_TWO: two };
  const script = '"$0" -db -f "$1" </dev/null & proxy=$!; cat; kill $proxy; wait $proxy';
  const kept = keeper(script, [haproxy() ?? "", own], { cwd: folder, env });
  let log = "";
  kept.said.on("data", (piece) => {
    log += piece;
  });
  const ask = async (/** @type {string} */ command) => {
    const connection = net.connect(socket);
    connection.end(`${command}\n`);
    return text(connection);
  };
  await until("the proxy", () => ask("show version").catch(() => ""), Boolean);
  return { ask, trusted, log: () => log, end: kept.end };
}

/** @returns {Promise<Plant>} */
export async function startPlant() {
  const folder = await mkdtemp(path.join(tmpdir(), "flankfit-plant-"));
  const [store, port, ...ports] = await Promise.all([database(), freePort(), freePort(), freePort()]);
  // creates the schema, too
  const first = ["keys", "create", "--tenant", "plant", "--role", "admin", "--database-url", store.url];
  const admin = (await run(program(), first)).stdout.trim();
  const options = [`--database-url=${store.url}`, "--auth=required", "--trusted-proxies=127.0.0.0/8"];
  const [one, two] = await Promise.all(ports.map((at) => serve([`--bind=127.0.0.1:${at}`, ...options])));
  assert.ok(one && two);
  const servers = /** @type {const} */ ([one, two]);
  const front = await proxy(folder, port, ports);

  /** Returns the proxy's state of a server, by names. @param {Which} which @returns {Promise<Record<string, string>>} */
  const known = async (which) => {
    const [head, ...lines] = (await front.ask("show stat")).split("\n").map((line) => line.split(","));
    const line = lines.find(([backend, name]) => backend === "jobs" && name === NAMES[which]) ?? [];
    return Object.fromEntries((head ?? []).map((name, i) => [name, line[i] ?? ""]));
  };
  const ready = () =>
    Promise.all(
      /** @type {const} */ ([0, 1]).map((which) =>
        until(
          `the proxy and server ${which}`,
          () => known(which),
          (seen) => seen["status"] === "UP" && seen["check_status"] === "L7OK",
        ),
      ),
    );
  await ready();

  const of = (/** @type {Which} */ which, /** @type {string} */ key) => callOf(servers[which], { "x-api-key": key });
  const made = await Promise.all(
    /** @type {const} */ (["engineer", "operator", "reader"]).map(async (role) => {
      const { id, key } = await of(0, admin)("POST", "/v1/keys", { name: `${role} of the test`, role });
      return [role, { id, key }];
    }),
  );
  /** @type {Plant["keys"]} */
  const keys = { ...Object.fromEntries(made), admin: { id: "", key: admin } };
  const url = `https://${HOST}:${port}`;
  return {
    servers,
    keys,
    browser: [`--ignore-certificate-errors-spki-list=${front.trusted}`, `--host-resolver-rules=MAP ${HOST} 127.0.0.1`],
    at: (which, role = "engineer") => of(which, keys[role].key),
    only: async (which) => {
      await front.ask(`set server jobs/${NAMES[1 - which]} state drain; set server jobs/${NAMES[which]} state ready`);
    },
    both: async () => {
      for (const name of NAMES) await front.ask(`set server jobs/${name} state ready`);
    },
    requests: async (which) => Number((await known(which))["scur"]),
    metric: async (which, series) => {
      const metrics = await (await fetch(`${servers[which].url}/metrics`)).text();
      const line = metrics.split("\n").find((one) => one.startsWith(`${series} `));
      return Number(line?.split(" ").at(-1) ?? 0);
    },
    server: {
      url,
      folder,
      log: () =>
        [...servers.map((server) => server.log()), front.log()].map((log) => log.slice(-30000)).join("\n---\n"),
      start: async () => {
        for (const server of servers) {
          await server.signal("SIGCONT");
          if (!(await answers(server))) await server.start();
        }
        await ready();
      },
      stop: async () => {
        await Promise.all([front.end(), ...servers.map((server) => server.signal("SIGKILL"))]);
        await store.end();
        for (const place of [folder, ...servers.map((server) => server.folder)])
          await rm(place, { recursive: true, force: true });
      },
      signal: async () => assert.fail("a signal is for one of the servers"),
    },
  };
}

/** @param {Server} server */
const answers = ({ url }) =>
  fetch(`${url}/healthz`).then(
    () => true,
    () => false,
  );
