// wasm.js - runs bits.c as WebAssembly: node wasm.js FILE prints what the native program prints.
// SPDX-License-Identifier: MIT
const fs = require('fs');

WebAssembly.instantiate(fs.readFileSync(process.argv[2])).then(({ instance }) => {
    const bits = instance.exports.checksum() >>> 0;
    const numbers = instance.exports.numbers() >>> 0;
    console.log(bits.toString(16).padStart(8, '0') + ' over ' + numbers + ' numbers');
});
