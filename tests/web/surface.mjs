// The largest vertical distance of samples from triangles over them, measured at every sample of every triangle, by plain
// arithmetic that shares nothing with what it measures. Also for the meshes of others.

/**
 * positions: x, y, z of each vertex, x and z in samples. covered: how many samples some triangle covers. weight(place,
 * metres): what a distance counts at a sample, 0: it is not looked at.
 */
export function measure(heights, width, height, positions, triangles, weight = (_, metres) => metres) {
  const seen = new Uint8Array(width * height);
  let worst = 0;
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [triangles[t], triangles[t + 1], triangles[t + 2]].map((i) => [positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]]);
    const area = (b[0] - a[0]) * (c[2] - a[2]) - (c[0] - a[0]) * (b[2] - a[2]);
    if (area === 0) continue;
    const [left, right] = [Math.min(a[0], b[0], c[0]), Math.max(a[0], b[0], c[0])];
    const [top, bottom] = [Math.min(a[2], b[2], c[2]), Math.max(a[2], b[2], c[2])];
    for (let z = Math.max(Math.ceil(top), 0); z <= Math.min(bottom, height - 1); ++z)
      for (let x = Math.max(Math.ceil(left), 0); x <= Math.min(right, width - 1); ++x) {
        const u = ((x - a[0]) * (c[2] - a[2]) - (c[0] - a[0]) * (z - a[2])) / area;
        const v = ((b[0] - a[0]) * (z - a[2]) - (x - a[0]) * (b[2] - a[2])) / area;
        if (u < -1e-9 || v < -1e-9 || u + v > 1 + 1e-9) continue;
        const place = z * width + x;
        seen[place] = 1;
        worst = Math.max(worst, weight(place, Math.abs(heights[place] - (a[1] + u * (b[1] - a[1]) + v * (c[1] - a[1])))));
      }
  }
  return { worst, covered: seen.reduce((sum, one) => sum + one, 0) };
}

/** Hills of four sizes. */
export function hills(width, height) {
  return Float32Array.from({ length: width * height }, (_, i) => {
    const x = i % width, z = Math.floor(i / width);
    return 90 * Math.sin(x / 41) * Math.cos(z / 37) + 25 * Math.sin(x / 11 + z / 17) + 6 * Math.cos(x / 3.7) * Math.sin(z / 4.1) + Math.sin(x * z);
  });
}
