// Opens the timeline and the sound, and puts the page together.

import { Data } from "./data.js";
import { HostSound } from "./host_sound.js";
import { keepOffline } from "./offline.js";
import { Page } from "./page.js";
import { Sound } from "./sound.js";

try {
  const data = await Data.open();
  const { server } = data.info;
  const page = new Page(data, server?.audio === "host" ? new HostSound() : await Sound.open(data));
  await page.begin();
  window.overview = page;
  if (!server) keepOffline();
} catch (error) {
  document.getElementById("fault").textContent = `The page can't begin: ${error.message}`;
}
