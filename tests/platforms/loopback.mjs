/** Loaded before a program, by `node --import`: its servers are reached from this machine alone. */

import { Server } from 'node:net';

const listen = Server.prototype.listen;
Server.prototype.listen = function (...given) {
  const isPort = /^\d+$/.test(String(given[0])) && typeof given[1] !== 'string';
  return listen.apply(this, isPort ? [given[0], '127.0.0.1', ...given.slice(1)] : given);
};
