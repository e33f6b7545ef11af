// Heights of raster tiles, as maps have them: for mesh().

const decoders = {
  terrarium: (r, g, b) => r * 256 + g + b / 256 - 32768,
  mapbox: (r, g, b) => -10000 + (r * 65536 + g * 256 + b) * 0.1,
};

/** rgba: of an ImageData. Heights in metres, row by row; NaN where a texel is transparent. */
export function heightsOfTile(rgba, encoding = "terrarium") {
  const decode = decoders[encoding];
  if (!decode) throw new RangeError(`encoding: is ${encoding}; give terrarium or mapbox`);
  if (!(rgba?.length > 0) || rgba.length % 4 !== 0) throw new RangeError("rgba: give four bytes for each texel");
  return Float32Array.from({ length: rgba.length / 4 }, (_, i) =>
    rgba[4 * i + 3] === 0 ? NaN : decode(rgba[4 * i], rgba[4 * i + 1], rgba[4 * i + 2]));
}
