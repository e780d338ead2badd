// Films play by themselves while they are seen, without bars over them; a button, and a click, stop them. Readers who
// asked for less motion, and browsers without scripts, keep the bars and start them by hand.
const [PLAY, PAUSE] = ["M3 2l5 3-5 3z", "M3 2h1.5v6H3zM5.5 2H7v6H5.5z"];
for (const film of document.querySelectorAll(".gallery video")) {
  if (matchMedia("(prefers-reduced-motion: reduce)").matches) break;
  const button = document.createElement("button");
  let stopped = false;
  const show = () => {
    button.innerHTML = `<svg viewBox="0 0 10 10" aria-hidden="true"><path d="${film.paused ? PLAY : PAUSE}"/></svg>`;
    button.setAttribute("aria-label", `${film.paused ? "play" : "pause"} ${film.getAttribute("aria-label")}`);
  };
  const turn = () => {
    stopped = !film.paused;
    if (stopped) film.pause();
    else void film.play();
  };
  film.controls = false;
  film.after(button);
  film.parentElement.classList.add("plays");
  film.addEventListener("click", turn);
  button.addEventListener("click", turn);
  for (const event of ["play", "pause"]) film.addEventListener(event, show);
  new IntersectionObserver(([{ isIntersecting }]) => {
    if (!isIntersecting) film.pause();
    else if (!stopped) film.play().catch(show);
  }, { threshold: 0.4 }).observe(film);
  show();
}
