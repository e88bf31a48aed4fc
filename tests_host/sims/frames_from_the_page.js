// A client of the framed link, written from docs/reference/languages/frames.md alone: it shares no code with Passo.
//
//     node frames_from_the_page.js PORT      lines on stdin; what the board says, on stdout
//
// A line that begins with a ! goes as URGENT, without the !, one that begins with a ^ as CUT. Ends when each other line is answered.

const fs = require('fs')
const tty = require('tty')

const HELLO = Buffer.from('000e100101010404121d19050c0f1500', 'hex')
const KIND = { WELCOME: 2, DATA: 3, ACK: 4, AGAIN: 5, URGENT: 6, CUT: 7, LEAVE: 9, TAKEN: 10, CLOSED: 11 }
const wrap = number => ((number % 4096) + 4096) % 4096

const table = Array.from({ length: 256 }, (_, value) => {
  for (let bit = 0; bit < 8; bit++) value = value & 1 ? 0xedb88320 ^ (value >>> 1) : value >>> 1
  return value >>> 0
})
const crc32 = bytes => (bytes.reduce((crc, byte) => table[(crc ^ byte) & 255] ^ (crc >>> 8), 0xffffffff) ^ 0xffffffff) >>> 0

function build (kind, number, ack, credit, data) {
  const body = Buffer.alloc(9 + data.length)
  body.writeUInt16BE(kind * 4096 + number, 0)
  body.writeUInt16BE(credit * 4096 + ack, 2)
  body[4] = data.length
  data.copy(body, 5)
  body.writeUInt32LE(crc32(body.subarray(0, 5 + data.length)), 5 + data.length)
  const coded = Buffer.concat([Buffer.from([0]), body])
  let next = coded.length
  for (let at = coded.length - 1; at >= 0; at--) {
    if (coded[at] === 0) { coded[at] = next - at; next = at }
  }
  return Buffer.concat([Buffer.from([0]), coded, Buffer.from([0])])
}

function parse (chunk) {
  const coded = Buffer.from(chunk)
  let at = 0
  while (at < coded.length) { const step = coded[at]; coded[at] = 0; at += step }
  if (at !== coded.length || coded.length < 10) return null
  const body = coded.subarray(1)
  const length = body[4]
  if (body.length !== 9 + length || body.readUInt32LE(5 + length) !== crc32(body.subarray(0, 5 + length))) return null
  const [first, second] = [body.readUInt16BE(0), body.readUInt16BE(2)]
  return { kind: first >> 12, number: first & 4095, credit: second >> 12, ack: second & 4095, data: body.subarray(5, 5 + length) }
}

const [,, port] = process.argv
const fd = fs.openSync(port, fs.constants.O_RDWR | fs.constants.O_NOCTTY)
const stream = new tty.ReadStream(fd)
stream.setRawMode(true)

const say = bytes => fs.writeSync(fd, bytes)
const send = (kind, number, data = Buffer.alloc(0)) => { owed = 0; say(build(kind, number, wanted, 15, data)) }
const fail = text => { process.stderr.write(text + '\n'); process.exit(1) }

let session = false // we are in one
let leaving = false
let first = 0 // number of the first byte that is not acknowledged
let out = Buffer.alloc(0) // from there on
let flying = 0
let limit = 0
let size = 64
let wanted = 0
let urgentNumber = 0
let urgents = []
let urgentSent = 0
let lastFrame = 0
let lastHello = 0
let lastAgain = 0
let progress = 0
let owed = 0
let partial = Buffer.alloc(0)
let awaited = 0
let answered = ''
const began = Date.now()

function queue (text) {
  for (const line of text.split('\n').filter(Boolean)) {
    if (line[0] === '!') urgents.push([KIND.URGENT, Buffer.from(line.slice(1), 'latin1')])
    else if (line[0] === '^') {
      const end = Buffer.alloc(2)
      end.writeUInt16BE(wrap(first + out.length))
      first = wrap(first + out.length)
      out = Buffer.alloc(0)
      flying = 0
      urgents.push([KIND.CUT, Buffer.concat([end, Buffer.from(line.slice(1), 'latin1')])])
    } else {
      out = Buffer.concat([out, Buffer.from(line + '\n')])
      awaited++
    }
  }
}

function askAgain (now) {
  if (session && now - lastAgain >= 30) { lastAgain = now; send(KIND.AGAIN, 0) }
}

function acknowledged (frame, now) {
  const count = wrap(frame.ack - first)
  if (count > out.length) return
  limit = frame.credit * 64
  if (!count) return
  first = frame.ack
  out = out.subarray(count)
  flying = Math.max(0, flying - count)
  progress = now
}

function understand (frame, now) {
  lastFrame = now
  if (frame.kind === KIND.WELCOME) {
    if (session) { if (frame.data[1] && first) fail('the board was reset') } else if (frame.data[1]) {
      session = true
      first = frame.ack
      wanted = frame.number
      urgentNumber = frame.data.readUInt16BE(3)
      send(KIND.ACK, 0)
      queue(fs.readFileSync(0, 'latin1'))
    } else { // another program's
      wanted = frame.number
      send(KIND.LEAVE, frame.data.readUInt16BE(3))
      lastHello = now
    }
  }
  if (!session) return
  acknowledged(frame, now)
  if (frame.kind === KIND.CLOSED) fail('answers were lost')
  if (frame.kind === KIND.AGAIN) { flying = 0; size = Math.max(16, size >> 1) }
  if (frame.kind === KIND.TAKEN && urgents.length && frame.number === urgentNumber) {
    urgentNumber = wrap(urgentNumber + 1)
    urgents.shift()
    urgentSent = 0
  }
  if (frame.kind === KIND.DATA) {
    const known = wrap(wanted - frame.number)
    if (known > 2048) return askAgain(now)
    owed = owed || now
    const fresh = frame.data.subarray(known)
    wanted = wrap(wanted + fresh.length)
    process.stdout.write(fresh)
    answered += fresh.toString('latin1')
  }
}

function work () {
  const now = Date.now()
  if (!session) {
    if (now - began > 5000) fail('no frames there')
    if (now - lastHello >= 80) { lastHello = now; say(HELLO) }
    return
  }
  if (leaving) return
  const cut = urgents.some(([kind]) => kind === KIND.CUT)
  const waits = out.length || urgentSent
  if (waits && now - lastFrame > 250) {
    if (now - lastHello >= 80) { lastHello = now; say(HELLO) }
    return
  }
  if (!waits) lastFrame = now
  if (urgents.length && now - urgentSent >= 60) { urgentSent = now; send(urgents[0][0], urgentNumber, urgents[0][1]) }
  if (flying && now - progress > 200) { flying = 0; progress = now }
  while (!cut && flying < out.length && flying < 3 * size) {
    let end = out.lastIndexOf(10, flying + size - 1) + 1 // whole lines
    if (end <= flying) end = out.indexOf(10, flying) + 1
    if (end > limit) break
    if (!flying) progress = now
    send(KIND.DATA, wrap(first + flying), out.subarray(flying, end))
    flying = end
  }
  if (owed && now - owed >= 40) send(KIND.ACK, 0)
  if (!out.length && !urgents.length && (answered.match(/ok\r\n|error:\d+\r\n/g) || []).length >= awaited) {
    leaving = true
    send(KIND.LEAVE, urgentNumber)
    setTimeout(() => process.exit(0), 50)
  }
}

stream.on('data', bytes => {
  const now = Date.now()
  partial = Buffer.concat([partial, bytes])
  for (let at; (at = partial.indexOf(0)) >= 0;) {
    const chunk = partial.subarray(0, at)
    partial = partial.subarray(at + 1)
    if (chunk.length < 10) continue
    const frame = parse(chunk)
    if (frame) understand(frame, now)
    else askAgain(now)
  }
  work()
})
setInterval(work, 5)
