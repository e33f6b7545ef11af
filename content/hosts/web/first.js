import * as THREE from "three";
import { Terrain } from "fjell";
import { TerrainObject } from "fjell/three";

const renderer = new THREE.WebGLRenderer({ antialias: true });
renderer.setSize(innerWidth, innerHeight);
document.body.append(renderer.domElement);
const ground = new TerrainObject(await Terrain.open("packs/mountains.fjell", { maps: true }));
const sun = new THREE.DirectionalLight(0xffffff, 3), scene = new THREE.Scene().add(ground, sun);
sun.position.set(-2, 1.5, -1);
const camera = new THREE.PerspectiveCamera(50, innerWidth / innerHeight, 10, 1e5);
camera.position.set(15000, 5000, 30000);
camera.lookAt(15000, 1000, 15000);
renderer.setAnimationLoop((now) => {
  ground.update(camera, renderer, now / 1000);
  renderer.render(scene, camera);
});
