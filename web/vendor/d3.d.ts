export { bisector, extent, max, mean, median, min, quantileSorted, range, tickStep, ticks } from "d3-array";
export { contours } from "d3-contour";
export { Delaunay } from "d3-delaunay";
export type { ScaleContinuousNumeric, ScaleLinear, ScaleLogarithmic } from "d3-scale";
export { scaleBand, scaleLinear, scaleLog, scaleTime } from "d3-scale";
export { area, curveMonotoneX, curveStepAfter, line } from "d3-shape";
