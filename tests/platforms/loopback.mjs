/** Loaded before a program with `node --import`: make its servers listen on 127.0.0.1 only. */

import { Server } from 'node:net';

const listen = Server.prototype.listen;
Server.prototype.listen = function (...options) {
  const isPort = /^\d+$/.test(String(options[0])) && typeof options[1] !== 'string';
  return listen.apply(this, isPort ? [options[0], '127.0.0.1', ...options.slice(1)] : options);
};
