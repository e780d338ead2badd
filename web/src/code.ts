// The address of the page as a QR code, for a phone beside it.

import { encode } from "uqr";

const CELL = 4; // pixels

/** Draw an address; whether it is short enough. */
export function drawCode(canvas: HTMLCanvasElement, address: string): boolean {
  let code;
  try {
    code = encode(address, { ecc: "L", border: 4 });
  } catch {
    return false;
  }
  [canvas.width, canvas.height] = [CELL * code.size, CELL * code.size];
  const on = canvas.getContext("2d")!;
  on.fillStyle = "white";
  on.fillRect(0, 0, canvas.width, canvas.height);
  on.fillStyle = "black";
  code.data.forEach((row, y) => row.forEach((dark, x) => dark && on.fillRect(CELL * x, CELL * y, CELL, CELL)));
  return true;
}
