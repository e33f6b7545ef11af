// The promise of a snapshot (invariant 4): every sample of the original DEM under the file's mesh is within
// error_px_effective of it; in pixels of the picture too, where corner_safe says so.

// Calls visit(column, row, surface, weights) for every sample in the closed triangle.
function samplesOf(tile, a, b, c, visit) {
    const {columns: x, rows: y, y: height} = tile;
    const edge = (p, q, px, py) => (px - x[p]) * (y[q] - y[p]) - (x[q] - x[p]) * (py - y[p]);
    const area = edge(a, b, x[c], y[c]);
    if (area === 0) return;
    const [left, right] = [Math.min(x[a], x[b], x[c]), Math.max(x[a], x[b], x[c])];
    const [top, bottom] = [Math.min(y[a], y[b], y[c]), Math.max(y[a], y[b], y[c])];
    for (let row = top; row <= bottom; ++row)
        for (let column = left; column <= right; ++column) {
            const wa = edge(b, c, column, row) / area, wb = edge(c, a, column, row) / area,
                  wc = edge(a, b, column, row) / area;
            if (wa >= 0 && wb >= 0 && wc >= 0)
                visit(column, row, wa * height[a] + wb * height[b] + wc * height[c], [wa, wb, wc]);
        }
}

// Slopes against central differences of the original heights. Each height is off by at most half a quantum. Where pages
// were missing the differences were taken over more samples, a power of two, or not at all.
function checkNormals(tile, {size, spacing_m, quantum_m, converged}, at, problems) {
    for (let i = 0; i < tile.count; ++i) {
        const column = tile.columns[i], row = tile.rows[i], [nx, ny, nz] = tile.normals.subarray(3 * i, 3 * i + 3);
        // What half a step of 16 bits turns a slope by, where the lattice scales axes.
        const stored = tile.stored_normals.subarray(3 * i, 3 * i + 3), least = stored[1] - tile.direction_slack;
        const rounded = (axis) => tile.direction_slack / least * (1 + Math.abs(stored[2 * axis]) / least)
            * (tile.node.scale ? tile.node.scale[1] / tile.node.scale[2 * axis] : 1);
        const fits = (slope, axis, from, to) => {
            const run = (to - from) * spacing_m[axis],
                  rise = axis === 0 ? at(to, row) - at(from, row) : at(column, to) - at(column, from);
            if (Number.isNaN(rise)) return true; // beside a hole
            const slack = quantum_m / run + 1e-5 * (1 + slope * slope) + 2 ** -22 * Math.abs(at(column, row)) / run
                + rounded(axis);
            return Math.abs(slope - rise / run) <= slack;
        };
        const matches = (slope, axis, middle) => {
            const inside = (place) => place >= 0 && place < size[axis];
            for (let step = 1; step < size[axis]; step *= 2)
                for (const [from, to] of [[middle - step, middle + step], [middle, middle + step], [middle - step, middle]])
                    if (inside(from) && inside(to) && fits(slope, axis, from, to)) return true;
            return !converged && slope === 0;
        };
        problems.require(matches(-nx / ny, 0, column) && matches(-nz / ny, 1, row), 'normal',
            () => `${tile.name}: sample (${column}, ${row}) has slopes ${-nx / ny} and ${-nz / ny}`);
    }
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (v) => v.map((k) => k / Math.hypot(...v));

// The normal texture at a texture coordinate, between its texels.
function lookUp({size: [side], rgb}, u, v) {
    const place = (k) => Math.min(Math.max(k * side - 0.5, 0), side - 1), x = place(u), y = place(v);
    const [x0, y0] = [Math.floor(x), Math.floor(y)], [x1, y1] = [Math.min(x0 + 1, side - 1), Math.min(y0 + 1, side - 1)];
    const texel = (column, row, k) => rgb[3 * (row * side + column) + k] / 127.5 - 1;
    return [0, 1, 2].map((k) => (texel(x0, y0, k) * (x0 + 1 - x) + texel(x1, y0, k) * (x - x0)) * (y0 + 1 - y)
        + (texel(x0, y1, k) * (x0 + 1 - x) + texel(x1, y1, k) * (x - x0)) * (y - y0));
}

// The size of a triangle; those smaller than a texel gain nothing from the texture.
function texelsIn({uvs, normal_map: {size: [side]}}, [a, b, c]) {
    const [bu, bv, cu, cv] = [b, b, c, c].map((corner, k) => (uvs[2 * corner + k % 2] - uvs[2 * a + k % 2]) * side);
    return Math.abs(bu * cv - bv * cu) / 2;
}

// How far interpolated normals are from those of the DEM at one sample, in radians: without the texture, and with it.
function shadingAt(tile, corners, weights, real) {
    const mean = (values, width) => {
        const sum = new Array(width).fill(0);
        corners.forEach((corner, k) => {
            for (let i = 0; i < width; ++i) sum[i] += weights[k] * values[corner * width + i];
        });
        return sum;
    };
    const normal = unit(mean(tile.normals, 3)), tangent = unit(mean(tile.tangents, 4).slice(0, 3)),
          bitangent = cross(normal, tangent), [u, v] = mean(tile.uvs, 2), local = lookUp(tile.normal_map, u, v);
    const turned = unit([0, 1, 2].map((k) => tangent[k] * local[0] + bitangent[k] * local[1] + normal[k] * local[2]));
    return [normal, turned].map((one) => Math.acos(Math.min(dot(one, real), 1)));
}

// In pixels of the picture: how far apart a sample that it shows and the surface over it are. 0: it shows neither.
function pictureError(extras, sample, surface) {
    const {axes, viewport, eye, fov_y_deg} = extras, lambda = viewport[1] / (2 * Math.tan(fov_y_deg * Math.PI / 360));
    const project = (height) => {
        const from = [sample[0] - eye[0], height - eye[1], sample[2] - eye[2]], depth = dot(from, axes[2]);
        return {depth, x: dot(from, axes[0]) / depth * lambda, y: dot(from, axes[1]) / depth * lambda};
    };
    const real = project(sample[1]), drawn = project(surface);
    if (real.depth <= 0 || Math.abs(real.x) > viewport[0] / 2 || Math.abs(real.y) > viewport[1] / 2) return 0;
    return drawn.depth > 0 ? Math.hypot(real.x - drawn.x, real.y - drawn.y) : Infinity;
}

// How far the nearest sample of a kind is, in metres along the ground; it may be `most_m` away at most.
function nearest(column, row, size, spacing_m, most_m, wanted) {
    const [right, down] = spacing_m.map((one) => Math.ceil(most_m / one) + 1);
    let least = Infinity;
    for (let y = Math.max(row - down, 0); y <= Math.min(row + down, size[1] - 1); ++y)
        for (let x = Math.max(column - right, 0); x <= Math.min(column + right, size[0] - 1); ++x)
            if (wanted(x, y))
                least = Math.min(least, Math.hypot((x - column) * spacing_m[0], (y - row) * spacing_m[1]));
    return least;
}

// A rim is drawn to within the bound of its place: ground that is not drawn has a hole within it, and a hole that is
// drawn over has ground. At full resolution a triangle beside a hole is left out with its other corners.
function checkRims(tiles, extras, at, seen, scaleAt, problems) {
    const {size, spacing_m, error_px_effective} = extras;
    for (const {rectangle: {left, top, right, bottom}} of tiles)
        for (let row = top; row <= bottom; ++row)
            for (let column = left; column <= right; ++column) {
                const hole = Number.isNaN(at(column, row)), drawn = seen[row * size[0] + column] === 1;
                if (hole !== drawn) continue;
                const most_m = error_px_effective / scaleAt(column, row) + Math.hypot(...spacing_m) * 1.001;
                const away_m = nearest(column, row, size, spacing_m, most_m, (x, y) => Number.isNaN(at(x, y)) !== hole);
                problems.require(away_m <= most_m, hole ? 'rim' : 'cover',
                    () => `sample (${column}, ${row}) is ${hole ? 'a hole that is' : 'ground that is not'} drawn`);
            }
}

export function checkHeights(tiles, extras, heights, problems) {
    const {size, spacing_m, eye, quantum_m, rounding_m, viewport, error_px_effective: kept_px} = extras;
    if (!problems.require(
            heights.columns === size[0] && heights.rows === size[1], 'error', 'the DEM is not as large as the terrain'))
        return {};
    const at = (column, row) => heights.data[row * heights.columns + column];
    const half_fov = extras.fov_y_deg * Math.PI / 360, lambda = viewport[1] / (2 * Math.tan(half_fov));
    const corner = 1 + Math.tan(half_fov) ** 2 * (1 + (viewport[0] / viewport[1]) ** 2); // 1 / cos^2 in the corner
    const known = heights.data.find((height) => !Number.isNaN(height)); // stands for the height of a hole
    const scaleAt = (column, row) => {
        const height = at(column, row);
        return lambda / Math.hypot(column * spacing_m[0] - eye[0], (Number.isNaN(height) ? known : height) - eye[1],
            row * spacing_m[1] - eye[2]);
    };
    const seen = new Uint8Array(size[0] * size[1]);
    const found = {worst_px: 0, worst_m: 0, worst_picture_px: 0, kept_px, asked_px: extras.error_px};
    const shading = {samples: 0, without: 0, with: 0};
    for (const tile of tiles) {
        for (let i = 0; i < tile.indices.length; i += 3) {
            const corners = tile.indices.slice(i, i + 3), texels = tile.normal_map && texelsIn(tile, corners) > 1;
            samplesOf(tile, ...corners, (column, row, surface, weights) => {
                const first = !seen[row * size[0] + column];
                seen[row * size[0] + column] = 1;
                const height = at(column, row), error = Math.abs(height - surface), scale = scaleAt(column, row);
                if (Number.isNaN(height)) return;
                // Half a quantum for rounding to the lattice, what the file's own takes, and the rounding of a float height.
                const share = (quantum_m / 2 + rounding_m + 2 ** -22 * Math.abs(height)) * scale;
                found.worst_px = Math.max(found.worst_px, error * scale);
                found.worst_m = Math.max(found.worst_m, error);
                problems.require(error * scale <= kept_px * (1 + 1e-9) + share, 'error',
                    () => `sample (${column}, ${row}) is off by ${error} m, ${error * scale} px of ${kept_px}`);
                if (extras.corner_safe) {
                    const moved = pictureError(extras, [column * spacing_m[0], height, row * spacing_m[1]], surface);
                    found.worst_picture_px = Math.max(found.worst_picture_px, moved);
                    problems.require(moved <= kept_px * (1 + 1e-9) + share * corner, 'error',
                        () => `sample (${column}, ${row}) is off by ${moved} px of the picture, ${kept_px} are kept`);
                }
                if (!texels || !first || column % 3 || row % 3) return;
                // Over as many samples as a texel has.
                const {left, right} = tile.rectangle,
                      step = Math.max(Math.round((right - left) / tile.normal_map.size[0]), 1);
                const real = unit([
                    (at(column - step, row) - at(column + step, row)) / (2 * step * spacing_m[0]), 1,
                    (at(column, row - step) - at(column, row + step)) / (2 * step * spacing_m[1])
                ]);
                const inner = column >= step && row >= step && column < size[0] - step && row < size[1] - step;
                if (!inner || real.some(Number.isNaN)) return;
                const [without, turned] = shadingAt(tile, corners, weights, real);
                ++shading.samples;
                shading.without += without;
                shading.with += turned;
            });
        }
        if (tile.normals) checkNormals(tile, extras, at, problems);
    }
    checkRims(tiles, extras, at, seen, scaleAt, problems);
    if (shading.samples) {
        found.shading_off_deg = [shading.without, shading.with].map((sum) => sum / shading.samples * 180 / Math.PI);
        const [without, turned] = found.shading_off_deg;
        problems.require(turned <= Math.max(0.75 * without, 4), 'shading',
            `normals are ${turned} degrees off with the normal texture, ${without} without`);
    }
    return found;
}
