export type { ComponentChildren, ComponentType, JSX, RefObject, TargetedEvent, VNode } from "preact";
export {
  cloneElement, createContext, createRef, Fragment, h, isValidElement, render, toChildArray,
} from "preact";
export {
  useCallback, useContext, useEffect, useErrorBoundary, useId, useLayoutEffect, useMemo, useReducer, useRef, useState,
} from "preact/hooks";
export type { ReadonlySignal, Signal } from "@preact/signals";
export {
  batch, computed, effect, signal, untracked, useComputed, useSignal, useSignalEffect,
} from "@preact/signals";
import type { ComponentChildren, VNode } from "preact";
/** A template has one element at its top, or it is a fragment in a component's hands. */
export function html(strings: TemplateStringsArray, ...values: unknown[]): VNode;
