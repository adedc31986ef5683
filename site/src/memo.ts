// A part that is worked out anew only where something that it is given is another. Preact's own memo comes with its
// React layer, which makes every onChange of an input one of each key, for all of the page: a minus sign alone is no
// number, and what is typed would be put back before its digits come.

import { Component, type ComponentType, type FunctionComponent, h, type JSX } from "preact";

export function memo<P extends object>(part: FunctionComponent<P>): ComponentType<P> {
  return class extends Component<P> {
    override shouldComponentUpdate(next: Readonly<P>): boolean {
      const names = new Set([...Object.keys(this.props), ...Object.keys(next)]) as Set<keyof P>;
      return [...names].some((name) => !Object.is((this.props as P)[name], next[name]));
    }

    override render(): JSX.Element {
      return h(part, this.props as P);
    }
  };
}
