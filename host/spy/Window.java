package ssv.spy;

import java.awt.BorderLayout;
import java.awt.Dimension;
import java.awt.event.ActionEvent;
import java.awt.event.WindowAdapter;
import java.awt.event.WindowEvent;
import javax.swing.AbstractAction;
import javax.swing.JComponent;
import javax.swing.JDesktopPane;
import javax.swing.JFrame;
import javax.swing.SwingUtilities;
import lcm.spy.ChannelData;

/** A window of lcm-spy that shows each message of a channel as it comes, in a view. */
final class Window<T> extends AbstractAction {
    /** Shows messages of one type, all of which come in the thread of the windows. */
    interface View<T> {
        JComponent component();

        void show(T message);
    }

    interface Maker<T> {
        View<T> make();
    }

    /** lcm-spy keeps the last message only and calls nobody, so it is asked so often; of two that come closer one is missed. */
    private static final int LOOK_MS = 1;

    private final Class<T> type;
    private final Maker<T> maker;
    private final Dimension size;
    private final JDesktopPane pane;
    private final ChannelData channel;

    /** lcm-spy wants the action once to know its name, with neither pane nor channel. */
    Window(String name, Class<T> type, Maker<T> maker, Dimension size, JDesktopPane pane, ChannelData channel) {
        super(name);
        this.type = type;
        this.maker = maker;
        this.size = size;
        this.pane = pane;
        this.channel = channel;
    }

    @Override
    public void actionPerformed(ActionEvent event) {
        View<T> view = maker.make();
        pane.setLayout(new BorderLayout());
        pane.add(view.component());
        Thread look = new Thread(() -> look(view), "look at " + channel.name);
        look.setDaemon(true);
        look.start();
        JFrame frame = (JFrame) SwingUtilities.getWindowAncestor(pane);
        frame.setSize(size);
        frame.setDefaultCloseOperation(JFrame.DISPOSE_ON_CLOSE);
        frame.validate();
        frame.addWindowListener(new WindowAdapter() {
            @Override
            public void windowClosed(WindowEvent closed) {
                look.interrupt();
            }
        });
    }

    private void look(View<T> view) {
        Object shown = null;
        try {
            while (true) {
                Object last = channel.last;
                if (last != shown && type.isInstance(last)) {
                    shown = last;
                    SwingUtilities.invokeLater(() -> view.show(type.cast(last)));
                }
                Thread.sleep(LOOK_MS);
            }
        } catch (InterruptedException closed) {
            return;
        }
    }
}
