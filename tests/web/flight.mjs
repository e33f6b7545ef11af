// One flight over one pack, in node and in a page; flight.cpp flies it natively, to the same bits. Eyes and thresholds are
// made of sums and products, for tan() is not the same everywhere.

const hashed = (hash, value) => Math.imul(hash ^ value, 16777619);

function sumOf(terrain) { // in whatever order the ranges are
  const { ranges, rangeCount } = terrain.frame, vertices = terrain.vertexSlots, indices = terrain.indexSlots;
  let sum = 0;
  for (let r = 0; r < rangeCount; ++r)
    for (let i = ranges[2 * r]; i < ranges[2 * r] + ranges[2 * r + 1]; i += 3) {
      let hash = 2166136261 | 0;
      for (let k = 0; k < 3; ++k)
        for (let n = 0; n < 3; ++n) hash = hashed(hash, vertices[3 * indices[i + k] + n]);
      sum = (sum + hash) | 0;
    }
  return sum;
}

function randomParts() {
  let state = 2024;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return ((state >>> 11) - (1 << 20)) / (1 << 20);
  };
}

const picture = { forward: [0, 0, -1], up: [0, 1, 0], left: -0.7363796664410578, right: 0.7363796664410578,
  bottom: -0.41421356237309503, top: 0.41421356237309503, width: 1280, height: 720, near: 1, far: 1e6, maxError: 0 };

export async function fly(Terrain, pack, module) {
  const terrain = await Terrain.open(pack, { whole: true, vertices: 6000, triangles: 12000, views: 2, module });
  const [wide, deep] = terrain.extent, part = randomParts();
  let triangles = 2166136261 | 0, work = 2166136261 | 0;
  const eye = [wide / 2, 4000, deep / 2];
  const views = [{ ...picture, eye }, { ...picture, eye: [0, 0, 0] }], one = [views[0]];
  for (let i = 0; i < 240; ++i) {
    const stride = i % 60 < 40 ? 20 : 400;
    const step = [part(), part() * 0.5, part()];
    for (let k = 0; k < 3; ++k) eye[k] += step[k] * stride;
    if (i % 80 === 79) {
      eye[0] = wide / 2 + part() * wide / 2;
      eye[1] = 3000 + part() * 1000;
      eye[2] = deep / 2 + part() * deep / 2;
    }
    [wide, 6000, deep].forEach((at, k) => { views[1].eye[k] = at - eye[k] * 0.25; });
    Object.assign(terrain.settings, { maxError: 0.75 + 3.25 * (Math.floor(i / 30) % 4), hysteresis: i % 120 < 60 ? 0 : 0.25, maxWork: i % 7 < 3 ? 150 : 0 });
    const f = terrain.update(i % 50 < 30 ? one : views, 0);
    triangles = hashed(triangles, sumOf(terrain));
    for (const n of [f.work, f.activations, f.deactivations, f.waiting, f.triangles]) work = hashed(work, n);
  }
  terrain.close();
  return [triangles, work].map((hash) => (hash >>> 0).toString(16).padStart(8, "0")).join(" ");
}
