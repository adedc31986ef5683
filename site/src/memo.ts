// Render a component again only if a property changed. Preact's own memo needs its React layer, which would make every
// onChange of an input fire at each key, for example after a minus sign alone.

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
