// The page of `make page` in headless Chromium: node browser.js CHROMIUM PAGE.html FOLDER. Writes a picture after each step
// to FOLDER and compares hello.png with FOLDER/native.png, gl_portable's. One line a check: "ok    name" or "FAIL  name".
'use strict';
const { spawn } = require('child_process');
const { readFileSync, rmSync, writeFileSync } = require('fs');
const { inflateSync } = require('zlib');
const path = require('path');

const [, , chromium, page, folder] = process.argv;
let failures = 0;

function check(good, name) {
    console.log((good ? 'ok    ' : 'FAIL  ') + name);
    if (!good) failures++;
}

// Bytes of a PNG of 8 bits, three or four channels; {width, height, at(x, y, c)}.
function decode(png) {
    const width = png.readUInt32BE(16), height = png.readUInt32BE(20), channels = png[25] === 6 ? 4 : 3;
    const parts = [];
    for (let at = 8; at < png.length; at += 12 + png.readUInt32BE(at))
        if (png.toString('latin1', at + 4, at + 8) === 'IDAT') parts.push(png.subarray(at + 8, at + 8 + png.readUInt32BE(at)));
    const raw = inflateSync(Buffer.concat(parts)), row = width * channels, out = Buffer.alloc(row * height);
    for (let y = 0; y < height; y++) {
        const filter = raw[y * (row + 1)];
        for (let x = 0; x < row; x++) {
            const a = x < channels ? 0 : out[y * row + x - channels], b = y ? out[(y - 1) * row + x] : 0;
            const c = x < channels || !y ? 0 : out[(y - 1) * row + x - channels], p = a + b - c;
            const pa = Math.abs(p - a), pb = Math.abs(p - b), pc = Math.abs(p - c);
            const paeth = pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
            out[y * row + x] = raw[y * (row + 1) + 1 + x] + [0, a, b, (a + b) >> 1, paeth][filter];
        }
    }
    return { width, height, at: (x, y, c) => out[y * row + x * channels + c] };
}

// Share of the pixels that differ by more than steps of 255 in some channel.
function different(a, b, steps, width, height) {
    let count = 0;
    for (let y = 0; y < height; y++)
        for (let x = 0; x < width; x++)
            if ([0, 1, 2].some(c => Math.abs(a.at(x, y, c) - b.at(x, y, c)) > steps)) count++;
    return count / (width * height);
}

// ---- The browser, by its protocol over pipes

// WebGL by the driver that the other tests run on: SwiftShader works for minutes on these shaders.
const profile = path.join(folder, 'profile');
const browser = spawn(chromium, ['--headless=new', '--no-sandbox', '--ignore-gpu-blocklist', '--use-angle=gl-egl',
    '--remote-debugging-pipe', '--window-size=1024,1000', '--hide-scrollbars',
    '--force-device-scale-factor=1', '--user-data-dir=' + profile, 'about:blank'],
    { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] });
const waiting = new Map();
let number = 0, received = '', session;

browser.stdio[4].on('data', data => {
    received += data;
    for (let end; (end = received.indexOf('\0')) >= 0; received = received.slice(end + 1)) {
        const answer = JSON.parse(received.slice(0, end));
        if (answer.id) waiting.get(answer.id)(answer.result || {});
    }
});

function send(method, params) {
    const id = ++number;
    browser.stdio[3].write(JSON.stringify({ id, method, params: params || {}, sessionId: session }) + '\0');
    return new Promise(done => waiting.set(id, done));
}

const value = async text => ((await send('Runtime.evaluate', { expression: text })).result || {}).value;
const sleep = ms => new Promise(done => setTimeout(done, ms));

// Once the page has drawn after what was done; its picture.
async function picture(name, frames) {
    for (let i = 0; i < 600 && !(await value('drawn') > frames || await value('failed')); i++) await sleep(100);
    const said = await value('failed');
    if (said) console.log(said);
    const data = await value("document.getElementById('canvas').toDataURL('image/png')");
    const png = Buffer.from(data.slice(data.indexOf(',') + 1), 'base64');
    writeFileSync(path.join(folder, name + '.png'), png);
    return decode(png);
}

async function drag(type, x, y) {
    await send('Input.dispatchMouseEvent', { type, x, y, button: 'left', buttons: type === 'mouseReleased' ? 0 : 1, clickCount: 1 });
}

async function run() {
    const target = await send('Target.createTarget', { url: 'file://' + path.resolve(page) });
    session = (await send('Target.attachToTarget', { targetId: target.targetId, flatten: true })).sessionId;
    const native = decode(readFileSync(path.join(folder, 'native.png')));
    const hello = await picture('hello', 0), width = native.width, height = native.height;
    const off = different(hello, native, 2, width, height);
    check(off < 0.005, `page: the hello scene in WebGL 2 is gl_portable's picture (${(100 * off).toFixed(2)}% of the pixels differ by more than 2 of 255)`);

    let frames = await value('drawn');
    await drag('mousePressed', 300, 300);
    await drag('mouseMoved', 330, 300);
    await drag('mouseReleased', 330, 300);
    const turned = await picture('turned', frames);
    check(different(turned, hello, 3, width, height) > 0.01, 'page: dragging turns the light');

    frames = await value('drawn');
    await send('Input.dispatchMouseEvent', { type: 'mouseWheel', x: 300, y: 300, deltaX: 0, deltaY: -100 });
    const wider = await picture('wider', frames), moved = different(wider, turned, 3, width, height);
    check(moved > 0.005 && moved < 0.2, `page: the wheel changes the light's size (${(100 * moved).toFixed(1)}% of the pixels)`);

    frames = await value('drawn');
    // Sixteen lights are much for a GPU made of a CPU.
    await value("Module.canvas.width = 320, Module.canvas.height = 240, _page_show(1)");
    const demo = await picture('demo', frames);
    const colors = new Set();
    for (let i = 0; i < 320 * 240; i++) colors.add([0, 1, 2].map(c => demo.at(i % 320, Math.floor(i / 320), c)).join());
    check(colors.size > 3000, `page: the demo's scene is shaded (${colors.size} colours)`);
    frames = await value('drawn');
    await drag('mousePressed', 100, 100);
    await drag('mouseMoved', 200, 100);
    await drag('mouseReleased', 200, 100);
    const probe = await picture('probe', frames);
    check(different(probe, demo, 8, 320, 240) > 0.02, 'page: dragging turns the probe');
    check(!(await value('failed')), 'page: nothing fails');
}

// Its processes may go on writing for a moment; rmSync's own retries are not of what lies deeper.
function remove_profile(left) {
    try {
        rmSync(profile, { recursive: true, force: true });
    } catch (e) {
        if (!left) throw e;
        setTimeout(remove_profile, 100, left - 1);
        return;
    }
    process.exit(failures ? 1 : 0);
}
browser.on('exit', () => remove_profile(50));
const limit = setTimeout(() => { check(false, 'page: the browser does not answer'); browser.kill('SIGKILL'); }, 240000);
run().catch(e => check(false, 'page: ' + e)).finally(() => { clearTimeout(limit); browser.kill(); });
