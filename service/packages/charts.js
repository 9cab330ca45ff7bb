/*! uPlot, Copyright (c) Leon Sorokin, MIT licence */
// What the pages use of uPlot; its style sheet is bundled beside it.
import "uplot/dist/uPlot.min.css";

export { default as Chart } from "uplot";
