// frames.mjs, briefly: that all three draw the same ground, and that what it counts is there. Not how long they take.
import assert from "node:assert/strict";
import test from "node:test";

import { measureFrames } from "./frames.mjs";

test("Fjell, CesiumJS and deck.gl fly over the same ground, and are measured alike", async () => {
  const results = await measureFrames({ pack: process.env.FJELL_PACK, names: ["fjell", "cesium", "deck, 4 m"], count: 3, size: { width: 240, height: 135 } });
  for (const [name, { first, error, flown, errors }] of Object.entries(results)) {
    assert.deepEqual(errors, [], name);
    const told = `${name}: ${JSON.stringify({ first, error, flown })}`;
    assert.ok(error.samples > 5000 && error.missing === 0, told);
    assert.ok(first.triangles > 1000 && flown.triangles > 1000 && first.bytes > 10_000 && flown.bytes >= first.bytes, told);
    assert.ok(error.worst <= (name === "fjell" ? 2 : 40), told); // other ground, or ground elsewhere, would be hundreds of pixels off
    console.log(told);
  }
});
