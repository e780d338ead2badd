// What time it is in the page, and how it goes on.

export class Player {
  /** In frames; what lies between two is shown between them. */
  place = 0;
  playing = false;
  speed = 1; // frames' time to the wall's, where 1 shows the run in about ten seconds
  loop = true;
  smooth = true;
  private last = 0;
  private readonly listeners: (() => void)[] = [];

  constructor(private readonly frames: () => number) {}

  onChange(listener: () => void): void {
    this.listeners.push(listener);
  }

  private told(): void {
    for (const listener of this.listeners) listener();
  }

  get end(): number {
    return Math.max(this.frames() - 1, 0);
  }

  get frame(): number {
    return Math.min(Math.floor(this.place), this.end);
  }

  get part(): number {
    return this.smooth ? this.place - this.frame : 0;
  }

  /** Frames a second at speed 1: the whole run in ten seconds, but between 5 and 60. */
  private get rate(): number {
    return Math.min(Math.max(this.end / 10, 5), 60);
  }

  toggle(): void {
    if (!this.playing && this.place >= this.end) this.place = 0;
    this.playing = !this.playing;
    this.last = 0;
    this.told();
  }

  seek(place: number): void {
    this.place = Math.min(Math.max(place, 0), this.end);
    this.told();
  }

  step(frames: number): void {
    this.playing = false;
    this.seek(Math.round(this.place) + frames);
  }

  faster(factor: number): void {
    this.speed = Math.min(Math.max(this.speed * factor, 1 / 16), 16);
    this.told();
  }

  /** On by the time that passed since the last call (ms). */
  tick(now: number): void {
    const passed = this.last ? Math.min((now - this.last) / 1000, 0.5) : 0;
    this.last = now;
    if (!this.playing || !this.end) return;
    const place = this.place + passed * this.rate * this.speed;
    if (place < this.end) this.place = place;
    else if (this.loop) this.place = place - this.end < this.end ? place - this.end : 0;
    else [this.place, this.playing] = [this.end, false];
    this.told();
  }
}
