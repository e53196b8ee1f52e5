// The socket: JSON goes out, a header with bytes comes in. A connection that is lost is opened again.

const RETRY_MS = 1000;

const handlers = {};
const on = (kind, handler) => {
  handlers[kind] = handler;
};

const token = new URLSearchParams(location.search).get('token') ?? '';

const connection = { socket: null, opened: 0, onOpen: () => {}, onLost: () => {} };

const receive = (buffer) => {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  handlers[header.kind]?.(header, buffer.slice(4 + length));
};

const connect = () => {
  const socket = new WebSocket(`ws://${location.host}/socket?token=${token}`);
  socket.binaryType = 'arraybuffer';
  socket.onopen = () => {
    connection.opened += 1;
    connection.onOpen();
  };
  socket.onmessage = (event) => receive(event.data);
  socket.onclose = () => {
    connection.onLost();
    setTimeout(connect, RETRY_MS);
  };
  connection.socket = socket;
};

const isOpen = () => connection.socket?.readyState === WebSocket.OPEN;

const send = (message) => {
  if (isOpen()) connection.socket.send(message instanceof ArrayBuffer ? message : JSON.stringify(message));
};
