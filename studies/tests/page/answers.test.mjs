import assert from "node:assert/strict";
import test from "node:test";
import { Answers } from "../../overview_studies/page/answers.js";
import { Refused, Server } from "../../overview_studies/page/client.js";
import { csvOf } from "../../overview_studies/page/csv.js";

/** A browser's store that forgets nothing, and fails when told to. */
class Disk {
  constructor() {
    this.map = new Map();
    this.full = false;
  }

  async put(key, value) {
    if (this.full) throw new Error("the disk is full");
    this.map.set(key, structuredClone(value));
  }

  async get(key) {
    return this.map.get(key);
  }

  async entries(prefix) {
    return [...this.map].filter(([key]) => key.startsWith(prefix)).sort();
  }
}

const row = (response) => ({ response, rt_ms: 1 });
const atOnce = () => Promise.resolve();

/** mulberry32 */
function seeded(seed) {
  let a = seed;
  return () => {
    a = (a + 0x6d2b79f5) | 0;
    let t = Math.imul(a ^ (a >>> 15), 1 | a);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

test("an answer counts once it is on the disk, and is sent until the server has it", async () => {
  const disk = new Disk();
  const stored = new Map();
  let fails = 3;
  const send = async (id, one) => {
    fails -= 1;
    if (fails >= 0) throw new Error("nothing answers");
    stored.set(id, one);
  };
  const answers = new Answers(disk, "s", send, { wait: atOnce });
  await answers.open();
  await answers.add("b1-001", row("goal"));
  assert.ok(disk.map.has("row s/b1-001"));
  await answers.sent();
  assert.deepEqual(stored.get("b1-001"), row("goal"));
  assert.equal(answers.unsent.size, 0);
  assert.equal(disk.map.get("row s/b1-001").sent, true);
});

test("a second answer to a trial is none, whenever it comes", async () => {
  const disk = new Disk();
  const answers = new Answers(disk, "s", null);
  await answers.open();
  await Promise.all([answers.add("t", row(1)), answers.add("t", row(2))]);
  await answers.add("t", row(3));
  assert.equal(answers.done.get("t").response, 1);
  assert.equal((await answers.rows()).length, 1);
});

test("an answer that the disk didn't take doesn't count and may be given again", async () => {
  const disk = new Disk();
  const answers = new Answers(disk, "s", null);
  await answers.open();
  disk.full = true;
  await assert.rejects(answers.add("t", row(1)), /full/);
  assert.equal(answers.has("t"), false);
  disk.full = false;
  await answers.add("t", row(1));
  assert.ok(answers.has("t"));
});

test("what the server has stored stays, whatever this browser kept", async () => {
  const disk = new Disk();
  await disk.put("row s/t", { number: 0, row: row(2), sent: false });
  const sent = [];
  const answers = new Answers(disk, "s", async (id) => sent.push(id), { wait: atOnce });
  await answers.open({ t: { response: 1, correct: true } });
  await answers.sent();
  assert.equal(answers.done.get("t").response, 1);
  assert.deepEqual(sent, []);
});

test("a refused answer is said and kept", async () => {
  const disk = new Disk();
  const lines = [];
  let refused = true;
  const send = async () => {
    if (refused) throw new Refused("no such trial", 404);
  };
  const wait = async () => {
    refused = false;
  };
  const answers = new Answers(disk, "s", send, { wait, onrefused: (line) => lines.push(line) });
  await answers.open();
  await answers.add("t", row(1));
  await answers.sent();
  assert.deepEqual(lines, ["no such trial"]);
});

const NEVER = new Promise(() => {});

/** One life of a tab: it asks for what is left until it is done or dies. What it did stays. */
async function life(disk, server, ids, acknowledged, random) {
  let alive = true;
  let deaths = 0;
  let die;
  const death = new Promise((resolve) => {
    die = resolve;
  });
  /** Go on, or never again. */
  const unless = (part) => {
    if (alive && random() < part) {
      alive = false;
      deaths += 1;
      die();
    }
    return alive ? Promise.resolve() : NEVER;
  };
  const mine = {
    async put(key, value) {
      await unless(0.02); // before it is on the disk
      await disk.put(key, value);
      await unless(0.02); // before anybody heard of it
    },
    get: (key) => disk.get(key),
    entries: (prefix) => disk.entries(prefix),
  };
  const fails = (part) => {
    if (random() >= part) return;
    deaths += 1;
    throw new Error("nothing answers");
  };
  const send = async (id, one) => {
    await unless(0.02);
    fails(0.15); // the server, before it has stored
    if (!server.has(id)) server.set(id, one.response);
    fails(0.15); // before it has answered
    await unless(0.02);
  };
  const told = Object.fromEntries([...server].map(([id, response]) => [id, { response }]));
  const answers = new Answers(mine, "s", send, { wait: () => unless(0.05) });
  const live = async () => {
    await answers.open(told);
    for (const id of ids.filter((one) => !answers.has(one))) {
      assert.ok(!acknowledged.has(id), `${id} is asked for again`);
      await unless(0.05); // while it is shown
      await answers.add(id, row(`${id} ${random()}`));
      acknowledged.add(id);
    }
    await answers.sent();
  };
  await Promise.race([live(), death]);
  return deaths;
}

test("tabs and servers that die at 1000 random points lose and repeat no answer", async () => {
  const random = seeded(7);
  const ids = Array.from({ length: 12 }, (_, i) => `t${i}`);
  let deaths = 0;
  while (deaths < 1000) {
    const disk = new Disk();
    const server = new Map(); // the first of each id
    const acknowledged = new Set();
    while (server.size < ids.length) {
      deaths += await life(disk, server, ids, acknowledged, random);
      for (const id of acknowledged) assert.ok(disk.map.has(`row s/${id}`), `${id} is lost`);
    }
    assert.deepEqual([...server.keys()].sort(), [...ids].sort());
    for (const id of ids) assert.equal(server.get(id), disk.map.get(`row s/${id}`).row.response);
  }
});

const answerOf = (status, body = "", type = "text/plain") =>
  new Response(body, { status, headers: { "content-type": type } });

test("a server that was started anew is entered again by itself", async () => {
  const asked = [];
  let inside = false;
  const ask = async (path, { method = "GET", headers = {} }) => {
    asked.push(`${method} ${path}`);
    if (path === "session") {
      inside = headers.Authorization === "Bearer abc";
      return new Response(null, { status: inside ? 204 : 401 });
    }
    return inside ? answerOf(201, "{}", "application/json") : answerOf(401, "open the address");
  };
  const server = new Server("abc", ask);
  server.sessions = "/study/sessions";
  await server.store({ session: "s", secret: "x" }, "t", row(1));
  const put = "PUT /study/sessions/s/trials/t";
  assert.deepEqual(asked, [put, "POST session", put]);
});

test("what would be refused again is told apart from what passes", async () => {
  for (const [status, refused] of [[400, true], [403, true], [404, true], [503, false], [429, false]]) {
    const server = new Server(null, async () => answerOf(status, "why"));
    const error = await server.file("a").catch((thrown) => thrown);
    assert.equal(error instanceof Refused, refused, String(status));
    assert.equal(error.message, "why");
  }
  const gone = new Server(null, () => Promise.reject(new TypeError("failed to fetch")));
  await assert.rejects(gone.file("a"), /the server does not respond/);
});

test("the CSV quotes what would end a field, and has a line for each answer", () => {
  const session = { session: "s1", participant: "p01", list: 2 };
  const rows = [
    ["b1-001", { received_utc: "2026-11-22T10:00:00.000Z", row: { response: "goal", correct: true } }],
    ["f", { received_utc: "x", row: { response: { comments: 'a "b",\nc' }, correct: null } }],
  ];
  const lines = csvOf([[session, rows]]).split("\r\n");
  assert.equal(lines[0], "session,participant,list,trial,received_utc,response,correct,rt_ms,row");
  assert.equal(lines[1],
    's1,p01,2,b1-001,2026-11-22T10:00:00.000Z,goal,true,,"{""response"":""goal"",""correct"":true}"');
  assert.match(lines[2], /"{""comments"":""a \\""b\\"",\\nc""}",,,/);
});
