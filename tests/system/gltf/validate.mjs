// Khronos' glTF validator over one file: node validate.mjs FILE.glb
// Prints every message and a summary. Exit code 0: no error and no warning; 1: some; 2: usage.
import validator from 'gltf-validator';
import fs from 'node:fs';

const severities = ['error', 'warning', 'info', 'hint'];

async function main(path) {
    if (!path) {
        console.error('usage: node validate.mjs FILE.glb');
        return 2;
    }
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(path)), {format: 'glb', maxIssues: 0});
    const {numErrors, numWarnings, numInfos, numHints, messages} = report.issues;
    for (const m of messages.slice(0, 20))
        console.log(`${severities[m.severity]} ${m.code} ${m.pointer ?? ''}: ${m.message}`);
    console.log(
        `validator ${report.validatorVersion}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} infos, ` +
        `${numHints} hints; ${report.info.totalVertexCount} vertices, ${report.info.totalTriangleCount} triangles`);
    return numErrors + numWarnings === 0 ? 0 : 1;
}

process.exitCode = await main(process.argv[2]);
