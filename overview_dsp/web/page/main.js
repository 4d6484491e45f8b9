// Puts the page together: let in, connect, draw.

import { Hand } from "./hand.js";
import { Link } from "./link.js";
import { enter, fetchData } from "./session.js";
import { View } from "./view.js";

const element = (id) => document.getElementById(id);

async function start() {
  await enter();
  const session = await fetchData("/data/session");
  const [first, last] = session.window;
  const data = await fetchData(`/data/timeline?start=${first}&end=${last}`);
  document.title = element("title").textContent = data.title || "overView";
  const view = new View(element("surface"));
  view.show(data);
  if (session.audio !== "host") {
    view.draw(0, null);
    throw new Error("to be the hand of a disk that sounds there, start it with --audio host");
  }
  const link = new Link();
  const hand = new Hand(element("surface"), (...event) => link.push(...event));
  let cursor = 0;
  let shown = data.window.join();
  link.addEventListener("connected", ({ detail, reason }) => {
    element("state").textContent = detail ? "connected" : reason || "not connected: the disk is free";
  });
  link.addEventListener("released", ({ detail }) => {
    element("state").textContent = detail;
  });
  link.addEventListener("status", async ({ detail }) => {
    cursor = detail.cursor;
    const { round_trip_ms: trip, event_to_sample_ms: sample, output_ms: output } = detail;
    element("latency").textContent = trip === null ? "" :
      `network ${trip.toFixed(0)} ms there and back` +
      (sample === null ? "" : `, finger to sound ${(sample + output).toFixed(0)} ms`);
    if (detail.window.join() !== shown) {
      shown = detail.window.join();
      view.show(await fetchData(`/data/timeline?start=${detail.window[0]}&end=${detail.window[1]}`));
    }
  });
  const frame = () => {
    view.draw(cursor, hand.touching ? hand.place : null);
    requestAnimationFrame(frame);
  };
  frame();
}

start().catch((error) => {
  element("state").textContent = error.message;
});
