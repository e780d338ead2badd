// Bytes in the fragment of a link.

/** Bytes in the characters that an address may have. */
export function coded(bytes: number[]): string {
  let text = "";
  for (let at = 0; at < bytes.length; at += 4096) text += String.fromCharCode(...bytes.slice(at, at + 4096));
  return btoa(text).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

/** The bytes of a fragment; null if it has other characters. */
export function decoded(fragment: string): number[] | null {
  try {
    return Array.from(atob(fragment.replaceAll("-", "+").replaceAll("_", "/")), (one) => one.charCodeAt(0));
  } catch {
    return null;
  }
}

/** The two bytes of a whole number, the higher one first. */
export function words(whole: number): [number, number] {
  return [whole >> 8, whole & 255];
}

/** The nearest whole number in a range. */
export function limited(value: number, least: number, most: number): number {
  return Math.min(Math.max(Math.round(value), least), most);
}
