import assert from "node:assert/strict";
import { test } from "node:test";
import { eventReader } from "../../app/lib/event_stream.js";

const TEXT =
  '\uFEFFretry: 2000\n\n: alive\n\nevent: iteration\nid: 7\ndata: {"number":7}\n\ndata: one\r\ndata:two\rdata\n\r\nevent: none\n\nid: 9\n\ndata: last\n\n';
const EVENTS = [
  { id: "7", event: "iteration", data: '{"number":7}' },
  { id: "7", event: "message", data: "one\ntwo\n" },
  { id: "9", event: "message", data: "last" },
];

test("events are read whatever the pieces", () => {
  for (let size = 1; size <= TEXT.length; size += 1) {
    const read = eventReader();
    const found = [];
    for (let at = 0; at < TEXT.length; at += size) found.push(...read(TEXT.slice(at, at + size)));
    assert.deepEqual(found, EVENTS, `pieces of ${size}`);
  }
});

test("what has not ended is no event yet", () => {
  const read = eventReader();
  assert.deepEqual(read("data: half"), []);
  assert.deepEqual(read("\n"), []);
  assert.deepEqual(read("\n"), [{ id: "", event: "message", data: "half" }]);
});
