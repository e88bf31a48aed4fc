// An emulated RP2350 for tests: orders as lines of JSON on stdin, answers on stdout. See rp2350.py.
//
//   node rp2350.js DIST UF2 IMAGE OFFSET COUNTER
//
// DIST: dist/cjs of rp2350js as built; IMAGE: a file system, that lies at OFFSET of the flash; COUNTER 0: the frequency counter does
// not answer. What the emulator does otherwise than the chip, as far as it was met, is mended here, by the RP2350's datasheet.
"use strict";
const fs = require("fs");
const path = require("path");
const readline = require("readline");
const Module = require("module");

const [dist, uf2, image, offset, counter] = process.argv.slice(2);

// What the emulator's processor does otherwise than an M33, mended as it is loaded: ADD of PC is short by 2; FP registers go through an
// interrupt as rounded numbers, and of a double only one word is loaded or stored.
const MENDED = {
  "execute-thumb16.js": [["const rightValue = regs.r[Rm];", "const rightValue = Rm === pcRegister ? regs.pc + 2 : regs.r[Rm];"]],
  "execute-fpu.js": [["    const regs = core.regs;\n", "    const regs = core.regs;\n    if (globalThis.movedFloats(core, hw0, hw1)) return 2;\n"]],
  "core.js": [
    ["regs.s[i] >>> 0);", "new Uint32Array(regs.s.buffer)[i]);"],
    ["regs.s[i] = this.chip", "new Uint32Array(regs.s.buffer)[i] = this.chip"],
  ],
};
const load = Module._extensions[".js"];
Module._extensions[".js"] = (module, name) => {
  const mends = name.startsWith(dist) && name.includes("cortex-m33") && MENDED[path.basename(name)];
  if (!mends) return load(module, name);
  let text = fs.readFileSync(name, "utf8");
  for (const [before, after] of mends) {
    if (!text.includes(before)) throw Error(`${name}: no ${before}`);
    text = text.replaceAll(before, after);
  }
  module._compile(text, name);
};

// VLDR, VSTR, VLDM, VSTM, VPUSH, VPOP of either precision, bit by bit.
globalThis.movedFloats = (core, high, low) => {
  const [before, up, write, isLoad] = [8, 7, 5, 4].map((bit) => high >> bit & 1);
  const double = (low >> 8 & 15) === 11;
  if ((high & 0xfe00) !== 0xec00 || (low >> 9 & 7) !== 5 || !(before || up)) return false;
  const { regs, chip } = core;
  const bits = new Uint32Array(regs.s.buffer);
  const register = high & 15, length = 4 * (low & 255), single = before && !write;
  const first = double ? (high >> 6 & 1) << 5 | (low >> 12 & 15) << 1 : (low >> 12 & 15) << 1 | high >> 6 & 1;
  const base = register === 15 ? regs.pc & ~3 : register === 13 ? regs.sp : regs.r[register];
  const moved = up ? base + length : base - length;
  const count = single ? 1 + double : low & (double ? 254 : 255);
  let at = single || before ? moved : base;
  for (let index = first; index < first + count; index++, at += 4) {
    if (isLoad) bits[index] = chip.readUint32(at >>> 0);
    else chip.writeUint32(at >>> 0, bits[index]);
  }
  if (write && register === 13) regs.sp = moved >>> 0;
  else if (write) regs.r[register] = moved >>> 0;
  return true;
};

const { RP2350 } = require(path.join(dist, "index.js"));
const { USBCDC } = require(path.join(dist, "usb", "cdc.js"));

const CLOCK_HZ = 150e6;
const SECTOR = 4096;

// The flash chip behind QMI's direct mode, by which the boot ROM erases and programs: single-wire commands, done at once.
class Flash {
  constructor(bytes) {
    this.bytes = bytes;
    this.csr = 0x01800000;
    this.answers = [];
    this.sent = [];
    this.other = [];
    for (let register = 0; register < 64; register++) this.other[register] = 0;
    for (let window = 0; window < 8; window++) this.other[13 + window] = 0x04000000 + 0x400 * (window % 4); // ATRANS
  }
  readUint32(offset) {
    if (offset === 0) return (this.csr | 1 << 11 | (this.answers.length ? 0 : 1 << 16)) >>> 0;
    if (offset === 8) return this.answers.shift() || 0;
    return this.other[offset >> 2];
  }
  writeUint32(offset, value) {
    if (offset === 0) {
      if (!(value & 4)) this.deselected(); // also between what AUTO_CS0N sends
      this.csr = value & 0xffc000fd;
    } else if (offset === 4) {
      let answer = this.clocked(value & 255, value >> 16 & 3);
      if (value & 1 << 18) answer |= this.clocked(value >> 8 & 255, value >> 16 & 3) << 8;
      if (!(value & 1 << 20)) this.answers.push(answer);
    } else this.other[offset >> 2] = value;
  }
  writeUint32Atomic(offset, value, type) {
    const before = type ? this.readUint32(offset) : 0;
    this.writeUint32(offset, type === 1 ? before ^ value : type === 2 ? before | value : type === 3 ? before & ~value : value);
  }
  clocked(byte, width) {
    if (width === 0) this.sent.push(byte);
    const command = this.sent[0], count = this.sent.length;
    if (command === 0x9f) return [0, 0xef, 0x40, 0x16][count - 1] || 0;
    if (command === 0x4b) return count > 5 ? count : 0;
    return 0;
  }
  deselected() {
    const [command, a, b, c, ...data] = this.sent;
    const at = a << 16 | b << 8 | c;
    this.sent = [];
    const erases = { 0x20: SECTOR, 0x52: 8 * SECTOR, 0xd8: 16 * SECTOR }[command];
    if (erases && c !== undefined) {
      const first = at & -erases;
      this.bytes.fill(255, first, first + erases);
    } else if (command === 2) {
      data.forEach((byte, index) => { this.bytes[(at & ~255) + (at + index & 255)] &= byte; });
    }
  }
}

const mcu = new RP2350({ coreArch: "arm" });
mcu.logger = { debug() {}, info() {}, warn() {}, error() {} };
mcu.clkSys = mcu.clkPeri = CLOCK_HZ;
mcu.peripherals[0x400d0] = new Flash(mcu.flash);
// The pins of the flash chip: registers that keep what is written, which the boot ROM looks at between two sectors.
class Kept {
  constructor() { this.registers = new Uint32Array(1024); }
  readUint32(offset) { return offset & 4 ? this.registers[offset >> 2] : 0xffffffff; } // the status: deselected
  writeUint32(offset, value) { this.registers[offset >> 2] = value; }
}
Kept.prototype.writeUint32Atomic = Flash.prototype.writeUint32Atomic;
mcu.peripherals[0x40030] = new Kept();

// The frequency counter: what CLOCKS gives back is all ones.
const clocks = mcu.peripherals[0x40010], read = clocks.readUint32.bind(clocks);
clocks.readUint32 = (offset) => offset === 0xa8 ? CLOCK_HZ / 1000 << 5 : offset === 0xa4 ? (counter === "0" ? 0 : 0x11) : read(offset);
// SysTick as it runs free: 24 bits of the processor's cycles, down.
const { ppb } = mcu, get = ppb.readUint32ViaCore.bind(ppb);
ppb.readUint32ViaCore = (offset, core) => (offset & 0xffff) === 0xe018 ? 0xffffff - cycle & 0xffffff : get(offset, core);
// UARTs: the interrupt "room to send" comes once a byte has gone, not for ever; DMA is told of what has come.
for (const uart of mcu.uart) {
  const write = uart.writeUint32.bind(uart), get = uart.readUint32.bind(uart), feed = uart.feedByte.bind(uart);
  uart.checkInterrupts = () => mcu.setInterrupt(uart.irq, !!(uart.interruptStatus & uart.interruptMask));
  uart.writeUint32 = (offset, value) => {
    write(offset, value);
    if (offset === 0) { uart.interruptStatus |= 1 << 5; uart.checkInterrupts(); }
  };
  uart.readUint32 = (offset) => {
    const value = get(offset);
    if (offset === 0 && uart.rxFIFO.empty) mcu.dma.clearDREQ(uart.dreq.rx);
    return value;
  };
  uart.feedByte = (byte) => { feed(byte); mcu.dma.setDREQ(uart.dreq.rx); };
}
// A length of 0 sets no DMA channel going: it ends a chain.
for (const channel of mcu.dma.channels) {
  const begin = channel.start.bind(channel);
  channel.start = () => { if (channel.transCountReload) begin(); };
}
mcu.loadFirmware(uf2, { initChip: false });
mcu.flash.set(fs.readFileSync(image), Number(offset));
mcu.reset();

const said = { usb: [], uart: [], edges: [] };
let cycle = 0;
const cdc = new USBCDC(mcu.usbCtrl);
cdc.onSerialData = (bytes) => { for (const byte of bytes) said.usb.push(byte); };
mcu.uart[0].onByte = (byte) => { said.uart.push(byte); };

// As mcu.step(), with a count of cycles that edges can be told by; blocks of PIO that rest are left out.
function step() {
  const cycles = mcu.stepCores();
  const running = mcu.pio.filter((block) => block.machinesRunning);
  if (running.length) {
    for (let count = 0; count < cycles; count++) {
      cycle++;
      for (const block of running) block.step();
    }
  } else cycle += cycles;
  mcu.clock.tick(cycles * 1e9 / CLOCK_HZ);
}

function run(us) {
  const end = cycle + us * CLOCK_HZ / 1e6;
  while (cycle < end) step();
}

function taken() {
  const text = (bytes) => Buffer.from(bytes).toString("latin1");
  const answer = { cycle, usb: text(said.usb), uart: text(said.uart), edges: said.edges };
  said.usb = []; said.uart = []; said.edges = [];
  return answer;
}

const ORDERS = {
  run(order) { run(order.us); return taken(); },
  usb(order) {
    for (const byte of Buffer.from(order.data, "latin1")) {
      if (cdc.txFIFO.full) throw Error("more than 512 bytes at once");
      cdc.sendSerialByte(byte);
    }
    return {};
  },
  uart(order) {
    Buffer.from(order.data, "latin1").forEach((byte, index) => mcu.clock.createAlarm(() => mcu.uart[0].feedByte(byte)).schedule(1e10 / order.baud * (index + 1)));
    return {};
  },
  pins(order) { for (const [pin, level] of Object.entries(order.levels)) mcu.gpio[pin].setInputValue(!!level); return {}; },
  watch(order) {
    for (const pin of order.pins) mcu.gpio[pin].addListener((now) => { said.edges.push([cycle, pin, now]); });
    return {};
  },
};

readline.createInterface({ input: process.stdin }).on("line", (line) => {
  const order = JSON.parse(line);
  let answer;
  try { answer = ORDERS[order.do](order); } catch (error) { answer = { error: String(error.stack) }; }
  process.stdout.write(JSON.stringify(answer) + "\n");
}).on("close", () => process.exit(0));
