// Checks a snapshot without a line of Fjell's code, from what the file says about itself.
//
//   node check.mjs FILE.glb... [--heights RAW COLUMNS ROWS] [--forward X Y Z] [--up X Y Z]
//
// RAW: the original heights, float32 little-endian, row by row from the north; NaN is a hole. FORWARD, UP: how the
// camera should stand. Prints a line of JSON a file. Exit code 0: nothing found; 1: problems, a line a kind.
import fs from 'node:fs';

import {parseGlb} from './glb.mjs';
import {checkHeights} from './heights.mjs';
import {checkShading, checkTextures, checkTopology} from './mesh.mjs';
import {checkCamera, checkExtras, Problems, readTiles} from './scene.mjs';

// file: Buffer. options: { heights: { data, columns, rows }, forward, up }. -> { problems, summary }
export function check(file, options = {}) {
    const problems = new Problems();
    const summary = {};
    try {
        const glb = parseGlb(file);
        const extras = checkExtras(glb, problems);
        const tiles = readTiles(glb, extras, problems), holes = options.heights?.data.some(Number.isNaN) ?? false;
        checkCamera(glb, extras, options, problems);
        Object.assign(summary, checkTopology(tiles, extras, holes, problems));
        checkShading(tiles, extras, problems);
        Object.assign(summary, checkTextures(glb, tiles, problems));
        if (options.heights) Object.assign(summary, checkHeights(tiles, extras, options.heights, problems));
    } catch (error) {
        problems.add('container', error.message);
    }
    return {problems, summary};
}

export function parseArguments(words) {
    const options = {}, paths = [];
    while (words.length && !words[0].startsWith('--')) paths.push(words.shift());
    while (words.length) {
        const word = words.shift();
        if (word === '--heights') {
            const bytes = fs.readFileSync(words.shift());
            const [columns, rows] = words.splice(0, 2).map(Number);
            const data = new Float32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4);
            if (data.length !== columns * rows)
                throw new Error(`--heights: ${data.length} samples, not ${columns} x ${rows}`);
            options.heights = {data, columns, rows};
        } else if (word === '--forward' || word === '--up') {
            options[word.slice(2)] = words.splice(0, 3).map(Number);
        } else {
            throw new Error(`unknown option ${word}`);
        }
    }
    return {paths, options};
}

function main(words) {
    const {paths, options} = parseArguments(words);
    let wrong = 0;
    for (const path of paths) {
        const {problems, summary} = check(fs.readFileSync(path), options), name = path.replace(/.*\//, '');
        for (const line of problems.lines()) console.log(`${name}: ${line}`);
        console.log(JSON.stringify({name, ...summary}));
        if (!problems.empty()) ++wrong;
    }
    return wrong || !paths.length ? 1 : 0;
}

if (process.argv[1] && import.meta.url.endsWith('/check.mjs') && process.argv[1].endsWith('check.mjs'))
    process.exitCode = main(process.argv.slice(2));
