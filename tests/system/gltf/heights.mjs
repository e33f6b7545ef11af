// The promise of a snapshot: every sample of the original DEM within error_px of the drawn surface (invariant 4).

// Calls visit(column, row, surface) for every sample in the closed triangle.
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
            if (wa >= 0 && wb >= 0 && wc >= 0) visit(column, row, wa * height[a] + wb * height[b] + wc * height[c]);
        }
}

// Slopes against central differences of the original heights. Each height is off by at most half a quantum.
function checkNormals(tile, {size, spacing_m, quantum_m}, at, problems) {
    for (let i = 0; i < tile.count; ++i) {
        const column = tile.columns[i], row = tile.rows[i];
        const [west, east] = [Math.max(column - 1, 0), Math.min(column + 1, size[0] - 1)];
        const [north, south] = [Math.max(row - 1, 0), Math.min(row + 1, size[1] - 1)];
        const [nx, ny, nz] = tile.normals.subarray(3 * i, 3 * i + 3);
        const compare = (slope, rise, run) => {
            const slack = quantum_m / run + 1e-5 * (1 + slope * slope) + 2 ** -22 * Math.abs(at(column, row)) / run;
            problems.require(Math.abs(slope - rise / run) <= slack, 'normal',
                () => `${tile.name}: sample (${column}, ${row}) has slope ${slope}, the DEM ${rise / run}`);
        };
        compare(-nx / ny, at(east, row) - at(west, row), (east - west) * spacing_m[0]);
        compare(-nz / ny, at(column, south) - at(column, north), (south - north) * spacing_m[1]);
    }
}

export function checkHeights(tiles, extras, heights, problems) {
    const {size, spacing_m, eye, quantum_m, viewport} = extras;
    if (!problems.require(
            heights.columns === size[0] && heights.rows === size[1], 'error', 'the DEM is not as large as the terrain'))
        return {};
    const at = (column, row) => heights.data[row * heights.columns + column];
    const lambda = viewport[1] / (2 * Math.tan(extras.fov_y_deg * Math.PI / 360));
    const asked = extras.converged ? extras.error_px : extras.error_px_effective;
    const seen = new Uint8Array(size[0] * size[1]);
    const found = {worst_px: 0, worst_m: 0, allowed_px: asked};
    for (const tile of tiles) {
        for (let i = 0; i < tile.indices.length; i += 3)
            samplesOf(tile, tile.indices[i], tile.indices[i + 1], tile.indices[i + 2], (column, row, surface) => {
                seen[row * size[0] + column] = 1;
                const height = at(column, row), error = Math.abs(height - surface);
                const scale =
                    lambda / Math.hypot(column * spacing_m[0] - eye[0], height - eye[1], row * spacing_m[1] - eye[2]);
                // Half a quantum for rounding to the lattice, and the rounding of a float height.
                const share = (quantum_m / 2 + 2 ** -22 * Math.abs(height)) * scale;
                found.worst_px = Math.max(found.worst_px, error * scale);
                found.worst_m = Math.max(found.worst_m, error);
                problems.require(error * scale <= asked + share, 'error',
                    () => `sample (${column}, ${row}) is off by ${error} m, ${error * scale} px of ${asked}`);
            });
        if (tile.normals) checkNormals(tile, extras, at, problems);
    }
    problems.require(!seen.includes(0), 'cover', 'a sample lies under no triangle');
    return found;
}
